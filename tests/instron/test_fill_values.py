"""Numbers that are none, as 1e400: refused before anything is calculated with them."""

import numpy as np
import pytest

import instron

N = 40
ROWS = [[f"{0.1 * i:.2f}", f"{0.05 * i:.3f}", f"{1.25 * i + 0.5:.3f}", "7.5"] for i in range(N)]
NAMES = ["Time (s)", "Extension (mm)", "Load (N)", "Stress (MPa)"]
QUANTITIES = ["time", "displacement", "force"]


def table(rows, names=NAMES):
    return "\n".join([",".join(names), *map(",".join, rows), ""])


def one(rows):
    return table(rows)


def without_time(rows):
    return table([row[1:] for row in rows], NAMES[1:])


def three_columns(rows):
    return table([row[:3] for row in rows], NAMES[:3])


def labelled(rows):
    """Two specimens under one header, told apart by their names; the second has the number."""
    stacked = [*([*row, "a"] for row in ROWS), *([*row, "b"] for row in rows)]
    return table(stacked, [*NAMES, "Specimen"])


def buffers(rows):
    """One test in four buffers, each under its own header, as MTS controllers write them."""
    size = N // 4
    return "\n".join(table(rows[k : k + size]) for k in range(0, N, size))


def beside(rows):
    return table([r + other for r, other in zip(rows, ROWS, strict=True)], NAMES + NAMES)


def cut(rows):
    """Let the end of the file cut a last row, so that the lines are walked one by one."""
    return table(rows) + "4.00,2.0"


LAYOUTS = [one, without_time, three_columns, labelled, buffers, beside, cut]


def read(tmp_path, text):
    path = tmp_path / "export.csv"
    path.write_text(text)
    return instron.read(path)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("numbers", [["1e400"], ["1e400", "1e400"], ["-1e400", "1e400"],
                                     ["1.7e308", "-1.7e308"], ["9E37"], ["-999999"]])  # fmt: skip
@pytest.mark.parametrize("start", [0, 13, N - 3])
def test_a_number_that_is_none_is_refused_in_its_line(tmp_path, layout, quantity, numbers, start):
    column = QUANTITIES.index(quantity)
    rows = [list(row) for row in ROWS]
    for row, text in enumerate(numbers, start):
        rows[row][column] = text
    text = layout(rows)
    if layout is without_time and quantity == "time":
        assert len(read(tmp_path, text)) == 1
        return
    line = next(n for n, row in enumerate(text.split("\n"), 1) if numbers[0] in row)
    reason = rf"line {line}: {quantity} {float(numbers[0]):g} is a fill value"
    with pytest.raises(instron.Unreadable, match=reason.replace("+", r"\+")):
        read(tmp_path, text)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_same_layouts_are_read_where_all_are_numbers(tmp_path, layout):
    logs = read(tmp_path, layout(ROWS))
    assert len(logs) == (2 if layout in (labelled, beside) else 1)
    for log in logs:
        assert np.isfinite(log["force"]).all()
        assert len(log) == N


def test_results_that_are_no_log_may_hold_them(tmp_path):
    results = "Extension (mm),Load (N)\n1e400,1e400\n\n"
    (log,) = read(tmp_path, results + table(ROWS))
    assert len(log) == N


@pytest.mark.parametrize("stated", ["1e400", "-1e400", "1.7e308,kN", "9E37", "0"])
def test_a_stated_maximum_that_is_none_is_no_check(tmp_path, stated):
    for above in (f"Maximum load,{stated}", f"Maximum load (N)\n{stated}"):
        (log,) = read(tmp_path, f"{above}\n\n" + table(ROWS))
        assert log.attrs["warnings"] == []


def test_a_stated_maximum_near_nothing_is_flagged(tmp_path):
    (log,) = read(tmp_path, "Maximum load,1e-320,N\n\n" + table(ROWS))
    assert "states a maximum of" in log.attrs["warnings"][0]


@pytest.mark.parametrize("unit", ["10^400 N", "x1e400 N", "x1e-400 N", "10^-400 N",
                                  f"1/{10**400} N", f"{'9' * 5000}/1 N"])  # fmt: skip
def test_a_factor_beyond_any_number_is_no_unit(tmp_path, unit):
    with pytest.raises(instron.Unreadable, match="line 1: "):
        read(tmp_path, table(ROWS, [*NAMES[:2], f"Load ({unit})", "Stress (MPa)"]))


def test_cells_of_five_thousand_digits_count_nothing(tmp_path):
    rows = [["1" * 5000, *row] for row in ROWS]
    assert len(read(tmp_path, table(rows, ["Row", *NAMES]))[0]) == N
    with pytest.raises(instron.Unreadable, match="5 cells under a header of 4"):
        read(tmp_path, table(rows))
