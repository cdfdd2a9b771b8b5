"""The ledger of lines: every line has one role, and blocks of one test are joined."""

import numpy as np
import pytest

import instron

N = 60
T = np.round(np.arange(N) * 0.1, 1)
X = np.round(T * 0.25, 4)
F = np.round(30 * np.sin(np.arange(N) / 9) ** 2 + 0.125, 4)
HEAD = "Time\tPosition\tForce\ns\tmm\tN\n"
TOP = "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n"


def rows(t=T, x=X, f=F, part=slice(None)):
    return "".join(f"{a}\t{b}\t{c}\n" for a, b, c in zip(t[part], x[part], f[part], strict=True))


def read(tmp_path, text, name="export.txt"):
    path = tmp_path / name
    path.write_bytes(text.encode())
    logs = instron.read(path)
    for log in logs:
        total = text.count("\n") + (not text.endswith("\n"))
        assert sum(log.attrs["lines"].values()) == total
    return logs


def thirds():
    return [slice(0, 20), slice(20, 40), slice(40, N)]


BLOCK_HEADS = {
    "tabs": "Data Acquisition\t\t\tTime:\t{}\ts\t1/1/2024 1:00:00 PM\n",
    "a number over a used column": "Data Acquisition\tTime:\t{}\ts\n",
    "words": "Buffer of the controller\n",
    "none": "",
}


@pytest.mark.parametrize("head", BLOCK_HEADS)
@pytest.mark.parametrize("blank", ["", "\n"])
@pytest.mark.parametrize("top", [TOP, "Test run 7\n"])
def test_buffers_of_one_test_are_joined_and_said_to_be(head, blank, top, tmp_path):
    text = top + blank.join(BLOCK_HEADS[head].format(i) + HEAD + rows(part=part)
                            for i, part in enumerate(thirds()))  # fmt: skip
    (log,) = read(tmp_path, text)
    np.testing.assert_array_equal(log["force"], F)
    np.testing.assert_array_equal(log["time"], T)
    assert "3 blocks joined to one test" in log.attrs["warnings"][0]
    assert log.attrs["lines"]["data"] == N


def test_blocks_without_time_are_joined_where_the_displacement_runs_on(tmp_path):
    head = "Position (mm)\tForce (N)\n"
    body = [f"{x}\t{f}\n" for x, f in zip(X, F, strict=True)]
    (log,) = read(tmp_path, head + "".join(body[:30]) + "\n" + head + "".join(body[30:]))
    np.testing.assert_array_equal(log["force"], F)


SEPARATE = {
    "time starts anew": (T, X),
    "a machine's clock, displacement starts anew": (T + 30, X),
    "clock runs on at once, displacement starts anew": (T + T[-1] + 0.1, X),
    "displacement runs on, after a long pause": (T + 4000, X + X[-1]),
}


@pytest.mark.parametrize("kind", SEPARATE)
@pytest.mark.parametrize("top", [TOP, "Specimen label\tb\n"])
def test_specimens_are_not_joined(kind, top, tmp_path):
    if top == TOP and "pause" in kind:
        pytest.skip("one file of this format is one test")
    t, x = SEPARATE[kind]
    logs = read(tmp_path, top + HEAD + rows() + "\nNext\n" + HEAD + rows(t, x))
    assert len(logs) == 2
    np.testing.assert_array_equal(logs[0]["force"], F)


def test_cycles_that_a_controller_kept_are_one_test(tmp_path):
    wave = np.round(np.sin(np.arange(N) / 5), 4)
    blocks = [f"Data Acquisition\tTime:\t{c}\ts\n" + HEAD + rows(T + 100 * c, wave) + "\n"
              for c in (1, 10, 100)]  # fmt: skip
    (log,) = read(tmp_path, TOP + "".join(blocks))
    assert len(log) == 3 * N


WHOLE = {
    "more digits": ["1.8", "1.7", "1.75"],
    "fewer, where zeros are left out": ["1.83", "1.79", "1.8"],
    "an integer, where zeros are left out": ["0.125", "0.128", "1"],
    "exponents": ["1.81e+03", "1.79e+03", "1.742e+03"],
}


@pytest.mark.parametrize("kind", WHOLE)
def test_a_good_last_row_is_kept(kind, tmp_path):
    forces = [*[WHOLE[kind][i % 2] for i in range(30)], WHOLE[kind][2]]
    text = HEAD + "\n".join(f"{i / 10}\t{i / 8}\t{f}" for i, f in enumerate(forces))
    (log,) = read(tmp_path, text)
    assert len(log) == 31
    assert log.attrs["warnings"] == []


@pytest.mark.parametrize("marks", [1, 2, 3])
@pytest.mark.parametrize("columns", ["Position;Force", "Time;Position;Force",
                                     "Point;Elongation;Force;Position"])  # fmt: skip
def test_last_rows_of_zeros_are_an_end_mark(marks, columns, tmp_path):
    values = {"Time": T + 0.1, "Point": T, "Position": X + 0.5, "Elongation": X + 0.5, "Force": F}
    names = columns.split(";")
    body = "".join(";".join(str(values[n][i]) for n in names) + "\n" for i in range(N))
    end = (";".join(["0"] * len(names)) + "\n") * marks
    (log,) = read(tmp_path, columns + "\n" + body + end)
    assert len(log) == N
    assert log.attrs["lines"]["end mark"] == marks
    assert "an end mark" in log.attrs["warnings"][0]


def test_a_test_that_comes_back_to_zero_has_no_end_mark(tmp_path):
    x = np.round(np.append(np.linspace(0, 1, 31), np.linspace(1, 0, 31)[1:]), 4)
    text = "Position;Force\n" + "".join(f"{v};{v * 3:.4f}\n" for v in x)
    (log,) = read(tmp_path, text)
    assert len(log) == 61


TABLE = "".join(f"{i}\t{i / 3:.3f}\n" for i in range(9))
OTHER_TABLES = {
    "without time": "\nPosition\tForce\nmm\tN\n" + "".join(f"{x}\t1{x}\n" for x in X),
    "fewer columns": "\nCycle\tPeak\n" + TABLE,
    "results as wide": "\nCycle\tMax load\tMin load\n" + TABLE.replace("\n", "\t0\n"),
    "no heading": "\nend\n" + TABLE,
}  # fmt: skip


@pytest.mark.parametrize("kind", OTHER_TABLES)
def test_rows_that_are_not_read_are_named(kind, tmp_path):
    (log,) = read(tmp_path, HEAD + rows() + OTHER_TABLES[kind])
    assert len(log) == N
    count = log.attrs["lines"]["lost"]
    assert count == (N if kind == "without time" else 9)
    assert f"{count} rows of another table" in log.attrs["warnings"][-1]


def test_roles_of_a_file(tmp_path):
    text = "Operator\tZoe\n\n" + HEAD + rows() + "\n\nEnd of test\n"
    (log,) = read(tmp_path, text)
    assert log.attrs["lines"] == {"blank": 3, "metadata": 2, "heading": 1, "units": 1, "data": N}


def test_a_clock_is_no_time_and_said_so(tmp_path):
    body = "".join(f"00:00:0{t:.1f}\t{x}\t{f}\n" for t, x, f in zip(T, X, F, strict=True))
    (log,) = read(tmp_path, "Time\tPosition (mm)\tForce (N)\n" + body)
    np.testing.assert_array_equal(log["force"], F)
    assert log["time"].isna().all()
    assert "hh:mm:ss" in log.attrs["warnings"][0]


@pytest.mark.parametrize("size", [1, 2, 3])
def test_buffers_of_a_row_or_two_are_one_test(size, tmp_path):
    parts = [slice(i, i + size) for i in range(0, N, size)]
    text = TOP + "\n".join(BLOCK_HEADS["tabs"].format(i) + HEAD + rows(part=part)
                           for i, part in enumerate(parts))  # fmt: skip
    (log,) = read(tmp_path, text)
    np.testing.assert_array_equal(log["force"], F)
    assert log.attrs["lines"]["data"] == N


def test_a_heading_over_every_row_is_one_test(tmp_path):
    text = "Camera trigger\n".join([""] + [HEAD + rows(part=slice(i, i + 1)) for i in range(N)])
    (log,) = read(tmp_path, text)
    np.testing.assert_array_equal(log["time"], T)


MARKS = {
    "the same": "Axial Counts\t0\n",
    "with numbers": "Axial Counts\t0\t{}\n",
    "counted": "Axial Counts\t{}\n",
    "alone": "Buffer\n",
}


@pytest.mark.parametrize("kind", MARKS)
@pytest.mark.parametrize("blank", ["", "\n"])
def test_a_mark_between_buffers_without_headings(kind, blank, tmp_path):
    marks = [MARKS[kind].format(i) for i in range(3)]
    text = "Test 7\n" + marks[0] + HEAD + rows(part=thirds()[0])
    text += "".join(blank + m + rows(part=p) for m, p in zip(marks[1:], thirds()[1:], strict=True))
    (log,) = read(tmp_path, text)
    np.testing.assert_array_equal(log["force"], F)
    assert log.attrs["lines"]["block head"] == 2
    assert "3 blocks" in log.attrs["warnings"][0]


@pytest.mark.parametrize("mark", ["Specimen\t{}\n", "Test run\t{}\n"])
def test_a_mark_that_counts_specimens_joins_nothing(mark, tmp_path):
    text = mark.format(1) + HEAD + rows() + mark.format(2) + rows(T + 10)
    with pytest.raises(instron.Unreadable, match="line 64"):
        read(tmp_path, text)


def test_a_mark_before_time_starts_anew_joins_nothing(tmp_path):
    text = "Buffer\n" + HEAD + rows() + "Buffer\n" + rows()
    with pytest.raises(instron.Unreadable, match="time jumps back"):
        read(tmp_path, text)


@pytest.mark.parametrize("delimiter", ["\t", ";", "|"])
def test_a_column_of_ones_own_beside_the_last_name(delimiter, tmp_path):
    body = "".join(f"{t}\t{x}\t{f}\t{-f}\t\t{note}\n" for t, x, f, note in
                   zip(T, X, F, ["-0.056", *[""] * (N - 1)], strict=True))  # fmt: skip
    head = "Time\tPosition\tForce\t\t\t\ns\tmm\tN\t\t\t-0.081\n"
    (log,) = read(tmp_path, (head + body).replace("\t", delimiter))
    np.testing.assert_array_equal(log["force"], F)


def test_a_cell_too_many_in_one_row_is_damage(tmp_path):
    lines = rows().splitlines()
    lines[7] = "0.7\t0\t0.175\t2.5"
    with pytest.raises(instron.Unreadable, match="line 10"):
        read(tmp_path, HEAD + "\n".join(lines) + "\n")


@pytest.mark.parametrize("word", ["hold", "Paused by operator", "eoh"])
def test_a_lone_word_between_two_rows_takes_none_away(word, tmp_path):
    lines = rows().splitlines(keepends=True)
    (log,) = read(tmp_path, HEAD + "".join([*lines[:9], word + "\n", *lines[9:]]))
    np.testing.assert_allclose(log["force"], F)
    assert any(f"line 12: '{word}' is no row" in note for note in log.attrs["warnings"])
    with pytest.raises(instron.Unreadable, match="line 12: text within the data"):
        read(tmp_path, HEAD + "".join([*lines[:9], word + "\n", *lines[10:]]))


@pytest.mark.parametrize("part", ["time", "displacement"])
def test_blocks_of_which_only_half_runs_on_are_said_to_be_two(part, tmp_path):
    t, x = T.copy(), X.copy()
    (t if part == "time" else x)[19 if part == "time" else 20] += 70
    first, second = (rows(t, x, part=slice(*ends)) for ends in ((0, 20), (20, N)))
    logs = read(tmp_path, HEAD + first + "\n" + HEAD + second)
    assert [len(log) for log in logs] == [20, 40]
    assert any(
        note.startswith("line 26: ") and "read as another test" in note
        for note in logs[1].attrs["warnings"]
    )
