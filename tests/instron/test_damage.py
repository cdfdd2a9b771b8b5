"""Damaged or doubtful files: refused with the reason, or flagged; never guessed."""

import numpy as np
import pytest

import instron

HEAD = "Time,Extension,Load\n(s),(mm),(N)\n"
TAB = "Time\tExtension\tLoad\ns\tmm\tN\n"


def line(i, delimiter=","):
    return delimiter.join([f"{i * 0.1:.2f}", f"{i * 0.05:.4f}", f"{100 + 1.25 * i:.4f}"])


def body(n=50, delimiter=","):
    return [line(i, delimiter) for i in range(n)]


def read(tmp_path, text, encoding="utf-8", **told):
    path = tmp_path / "damaged.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return instron.read(path, **told)


def with_row(row, at=20, head=HEAD, delimiter=","):
    rows = body(delimiter=delimiter)
    rows[at] = row
    return head + "\n".join(rows) + "\n"


REFUSED = {
    "empty file": (b"", "empty"),
    "zero bytes": (HEAD.encode() + b"0.1,0.2,3" + bytes(50), "line 3: zero bytes"),
    "xml method": ("<?xml version='1.0'?><Sample/>".encode("utf-16"), "XML"),
    "xml utf-8": (b"<?xml version='1.0'?><Sample/>", "XML"),
    "workbook": (b"PK\x03\x04" + bytes(range(1, 200)), "workbook"),
    "lost decimal point, quoted": (with_row('2.00,1.0000,"2,110,849"'), "line 23.*decimal point"),
    "lost decimal point, tab": (
        with_row("2.00\t1.0000\t2,110,849", head=TAB, delimiter="\t"),
        "line 23.*decimal point",
    ),
    "lost decimal point, unquoted": (with_row("2.00,1.0000,2,110,849"), "line 23: 5 cells"),
    "lost decimal point, throughout": (
        HEAD + "".join(f'{i * 0.1:.1f},{i * 0.05:.2f},"2,110,{849 + i}"\n' for i in range(9)),
        "line 3: '2,110,849' could be a decimal",
    ),
    "two points": (with_row("2.00\t1.0000\t2.110.849", head=TAB, delimiter="\t"), "line 23"),
    "one number grouped among larger ones that are not": (
        "Extension;Load\n(mm);(N)\n0,7;1688966,3\n1,1;26966,9\n2,4;399135,7\n3,4;76.061,7\n",
        "line 6: '76.061,7' groups its thousands, '1688966,3' in the same column does not",
    ),
    "decimal comma without quotes": (HEAD + "0,1,0,05,1,5\n" * 9, "6 cells under a header of 3"),
    "decimal comma without quotes, names to spare": (
        HEAD.replace("\n", ",a,b,c\n", 1) + "0,1,0,05,1,5,,,\n0,2,0,06,1,6,,,\n",
        "line 3: no decimal point anywhere",
    ),
    "decimal comma without quotes, no zeros": (
        HEAD.replace("\n", ",a,b,c\n", 1) + "".join(f"0,{i},4,{i},1,5\n" for i in range(10, 90)),
        "whole numbers only, and most times repeat",
    ),
    "stress for a load": (HEAD.replace("(N)", "(MPa)") + "1,2,3\n", "'Load' in 'MPa' is no force"),
    "fill -1000000": (with_row("2.00,1.0000,-1000000"), "line 23: force -1e\\+06 is a fill value"),
    "fill 9.99E+37": (with_row("2.00,1.0000,9.99E+37"), "line 23: .*fill value"),
    "fill -----": (with_row("2.00,1.0000,-----"), "line 23: .*'-----'"),
    "fill *****": (with_row("2.00,*****,3.0"), r"line 23: .*'\*\*\*\*\*'"),
    "OVER": (with_row("2.00,1.0000,OVER"), "line 23: .*'OVER'"),
    "1.#INF": (with_row("2.00,1.0000,1.#INF"), "line 23: .*'1.#INF'"),
    "inf": (with_row("2.00,1.0000,inf"), "line 23"),
    "nan in the force": (with_row("2.00,1.0000,nan"), "line 23"),
    "row shifted by a delimiter": (
        with_row('\t"2.00"\t"1.0000"\t"3.0"', at=0, head=TAB, delimiter="\t"),
        "line 3: 4 cells under a header of 3",
    ),
    "grouping blanks are no delimiter": (
        "Time\tExtension\tLoad\n(s)\t(mm)\t(N)\n1\u00a0319\u00a09",
        "no row of numbers",
    ),
    "gap": (with_row("2.00,1.0000,"), "line 23: a row lacks numbers"),
    "letter in a number": (with_row("2.00,1.0000,12x.5"), "line 23: .*'12x.5'"),
    "time runs back": (with_row("0.30,1.0000,125.0"), "line 23: time jumps back"),
    "text within the data": (with_row("paused by operator"), "line 23: text within the data"),
    "voltage logger": ("Time,Displacement,Load\n(s),(V),(V)\n" + "\n".join(body()), "volt"),
    "strain and stress only": ("Strain (%),Stress (MPa)\n1,2\n2,3\n", "no header that names"),
    "no force": ("Time (s),Extension (mm)\n0,1\n1,2\n", "no force column"),
    "no header": ("\n".join(body()), "no header"),
    "unknown unit": ("Time (s),Extension (mm),Load (zorg)\n" + "\n".join(body()), "unit|zorg"),
    "ambiguous commas": (TAB + "1\t2\t1,424\n2\t3\t1,425\n", "could be a decimal or a thousand"),
    "two decimal marks": (
        TAB + "0.5\t2\t0,25\n0.6\t3\t0,5\n",
        "decimal (comma.*decimal point|point.*decimal comma)",
    ),
    "broken grouping": (with_row('2.00,1.0000,"1,42.96"'), "line 23: '1,42.96' is not a number"),
    "lost decimal point beside grouped numbers": (
        HEAD
        + "".join(f'{i},{i / 8:.3f},"{9e4 + i * 7e3:,.1f}"\n' for i in range(9))
        + '9,1.125,"1,539,375"\n',
        "line 12: '1,539,375' alone has no decimals",
    ),
    "commas in quotes beside a bare 0": (
        HEAD + '0,12,"1,424"\n1,13,"1,430"\n',
        "'1,424' could be a decimal or a thousand",
    ),
    "a single number that tells": (
        TAB + "1\t2\t469.943\n2\t3\t96.80\n",
        "'469.943' could be .* only '96.80' tells",
    ),
    "points that may group, quoted": (
        HEAD + '"1","2","998"\n"2","3","1.002"\n',
        "'1.002' could be a decimal",
    ),
    "points that may group": (TAB + "1\t2\t998\n2\t3\t1.002\n", "'1.002' could be a decimal"),
    "quote within a number": (
        HEAD + '"0.1","0.2","0.3"\n"0.2","0.3","773.98"5.00"\n"0.3","0.3","0.4"\n',
        "line 4: a quote is not closed",
    ),
    "quotes within a number": (
        HEAD + '"0.1","0.2","0.3"\n"0.2","0.3","773.98"5""\n"0.3","0.3","0.4"\n',
        "line 4",
    ),
    "two quotes behind a number": (
        HEAD + '0.1,0.2,0.3\n0.2,0.35"",5.0\n0.3,0.4,0.5\n0.4,0.5,0.7\n',
        "line 4: quotes within a number",
    ),
    "two quotes before a number": (
        HEAD + '0.1,0.2,0.3\n0.2,""0.35,5.0\n0.3,0.4,0.5\n0.4,0.5,0.7\n',
        "line 4: quotes within a number",
    ),
    "lone return within a number": (
        HEAD.replace("\n", "\r\n") + "0.1,0.2,4.8\r\n0.2,0.3,4\r.8\r\n0.3,0.4,4.8\r\n",
        "line 4: a carriage return within the line",
    ),
    "lone return in lines of LF": (with_row("2.00,1.0\r000,3.0"), "line 23: a carriage return"),
    "lone return, UTF-16": (
        (HEAD + "0.1,0.2,4.8\n0.2,0.3,4\r.8\n").encode("utf-16"),
        "line 4: a carriage return",
    ),
    "header only": (HEAD, "no row of numbers"),
    "only one number with a mark, that may be damaged": (
        "Time;Extension;Load\n(s);(mm);(N)\n,1;-0;0\n1;0;0\n1;1;0\n",
        "line 3: ',1' could be a decimal or a thousand: only ',1' tells",
    ),
    "stated maximum a unit off": (
        "Maximum load,161.25,N\n\n" + HEAD.replace("(N)", "(lbf)") + "\n".join(body()) + "\n",
        "states a maximum of .* N, the rows reach 717.276 N: a power of ten or a unit",
    ),
    "stated maximum ten times off": (
        "Maximum load,1612.5,N\n\n" + HEAD + "\n".join(body()) + "\n",
        "states a maximum of 1612.5 N.*power of ten",
    ),
}


@pytest.mark.parametrize(
    "first", ["-0-0", "1190;1", "0.1|0.2|3.0", "12", "0.1 0.2 3.0", "'0.1'0.2"]
)
def test_a_first_row_that_lost_its_delimiters_is_no_comment(tmp_path, first):
    with pytest.raises(instron.Unreadable, match="line [13]: "):
        read(tmp_path, HEAD + first + "\n0,1,0\n0,1,0\n")


@pytest.mark.parametrize(("end", "lost"), [("0.3,,", 1), ("0.3,,\n", 1), ("0.3,,\n0.4,,\n", 2),
                                           (",,\n0.3,,\n,,\n", 1), (",,\n,,\n", 0)])  # fmt: skip
def test_times_alone_at_the_end_are_counted(tmp_path, end, lost):
    (log,) = read(tmp_path, HEAD + "0.1,1,0.5\n0.2,1.1,0.75\n" + end)
    assert len(log) == 2
    assert log.attrs["lost_rows"] == lost
    assert len(log.attrs["warnings"]) == bool(lost)


@pytest.mark.parametrize("first", ["0.1x0.2x3.0", "o.1,o.2,o.3 5", "1e-3;1;7", "run 4, in water"])
def test_digits_between_heading_and_rows_are_named(tmp_path, first):
    (log,) = read(tmp_path, HEAD + first + "\n0.1,1,0.5\n0.2,1.1,0.75\n")
    assert log.attrs["warnings"] == [f"line 3: '{first}' is taken for a comment"]
    (log,) = read(tmp_path, HEAD + "in water\n0.1,1,0.5\n0.2,1.1,0.75\n")
    assert log.attrs["warnings"] == []


def as_a_german_spreadsheet_reads(text):
    """Take the point of ``1.0114`` for a thousands mark, and that of ``1.063`` not to be one."""
    whole, _, decimals = text.rstrip("0").partition(".")
    if whole != "0" and len(decimals) == 4:
        whole, decimals = (whole + decimals)[:-3], (whole + decimals)[-3:]
    return f"{whole},{decimals}" if decimals else whole


def test_points_that_a_spreadsheet_moved_are_refused(tmp_path):
    times = [i * 0.02 for i in range(400)]
    travel = [f"{0.1366 + 0.8497 * t:.4f}" for t in times]
    rows = "".join(f"{t:.2f};{as_a_german_spreadsheet_reads(x)};0.5\n".replace(".", ",")
                   for t, x in zip(times, travel, strict=True))  # fmt: skip
    head = "Time;Displacement;Force\n(s);(mm);(kN)\n"
    with pytest.raises(
        instron.Unreadable, match=r"line 5\d: displacement jumps from .*spreadsheet"
    ):
        read(tmp_path, head + rows)
    wave = "".join(f"{t:.2f};1,0;{[10, 100][i // 50 % 2] + i % 3},5\n".replace(".", ",")
                   for i, t in enumerate(times))  # fmt: skip
    assert read(tmp_path, head + wave)[0].attrs["warnings"] == []
    sound = "".join(f"{t:.2f};{x};0.5\n" for t, x in zip(times, travel, strict=True))
    assert read(tmp_path, head + sound)[0].attrs["warnings"] == []


@pytest.mark.parametrize("damage", REFUSED)
def test_damage_is_refused_with_its_reason(damage, tmp_path):
    content, reason = REFUSED[damage]
    with pytest.raises(instron.Unreadable, match=reason) as caught:
        read(tmp_path, content)
    assert "damaged.csv" in str(caught.value)
    assert caught.value.users_fault


@pytest.mark.parametrize("keep", range(1, len(line(49)) + 1))
def test_a_file_cut_in_mid_row_keeps_the_good_rows(keep, tmp_path):
    whole = HEAD + "\n".join(body(50)) + "\n"
    cut = HEAD + "\n".join(body(49)) + "\n" + line(49)[:keep]
    log = read(tmp_path, cut)[0]
    full = read(tmp_path, whole)[0]
    if keep == len(line(49)):
        assert len(log) == 50
        assert log.attrs["lost_rows"] == 0
    else:
        assert len(log) == 49
        assert log.attrs["lost_rows"] == 1
        assert "1 row lost" in log.attrs["warnings"][0]
    np.testing.assert_array_equal(log, full.iloc[: len(log)])


def test_a_file_cut_in_a_quote_keeps_the_good_rows(tmp_path):
    rows = "".join('"' + '","'.join(row.split(",")) + '"\n' for row in body(30))
    log = read(tmp_path, HEAD + rows + '"3.00","1.50')[0]
    assert len(log) == 30
    assert log.attrs["lost_rows"] == 1


def test_a_last_row_that_jumps_back_is_dropped_and_told(tmp_path):
    log = read(tmp_path, HEAD + "\n".join([*body(30), "0.00,0.0000,1.0000"]) + "\n")[0]
    assert len(log) == 30
    assert "jumps back from 2.9 s to 0 s" in log.attrs["warnings"][0]
    assert log.attrs["lines"]["lost"] == 1


def test_milliseconds_under_a_header_of_seconds_are_flagged(tmp_path):
    rows = "\n".join(f"{100 * i},{i * 0.01:.3f},{i}" for i in range(50))
    log = read(tmp_path, HEAD + rows + "\n")[0]
    assert "may be in ms" in log.attrs["warnings"][0]


def test_milliseconds_are_known_by_the_speed_that_the_file_states(tmp_path):
    rows = "\n".join(f"{20.5 * i},{i * 0.01:.3f},{i}" for i in range(50))
    for rate, flagged in (("30.0", True), ("0.03", False)):
        text = f"Test : Rate 1,{rate},mm/min\n\n{HEAD}{rows}\n"
        notes = read(tmp_path, text)[0].attrs["warnings"]
        assert any("may be in ms" in note for note in notes) == flagged


def test_units_that_nobody_stated_are_flagged(tmp_path):
    text = "Time,Extension,Load\n" + "\n".join(body())
    log = read(tmp_path, text)[0]
    assert sum("not stated" in note for note in log.attrs["warnings"]) == 3
    told = read(tmp_path, text, units={"time": "s", "displacement": "in", "force": "lbf"})[0]
    assert told.attrs["warnings"] == []
    assert told["displacement"].iloc[1] == pytest.approx(0.05 * 0.0254)


def test_a_unit_told_that_is_none_is_refused(tmp_path):
    for units in ({"force": "zorg"}, {"force": "mm"}, {"weight": "N"}):
        with pytest.raises(instron.Unreadable, match="told that .* no unit of"):
            read(tmp_path, HEAD + "\n".join(body()), units=units)


def test_a_folder_is_no_export(tmp_path):
    with pytest.raises(instron.Unreadable, match="directory"):
        instron.read(tmp_path)


def test_specimens_in_different_units_are_flagged(tmp_path):
    one = HEAD + "\n".join(body()) + "\n\n"
    logs = read(tmp_path, one + one.replace("(N)", "(kN)"))
    assert logs[1]["force"].iloc[0] == 1000 * logs[0]["force"].iloc[0]
    assert all("differ in the unit of force" in log.attrs["warnings"][0] for log in logs)


def test_a_maximum_that_the_rows_do_not_reach_is_flagged(tmp_path):
    text = "Maximum Load (N),Extension at Maximum Load (mm)\n999.86,3.0\n\n" + HEAD
    log = read(tmp_path, text + "\n".join(body()) + "\n")[0]
    assert "states a maximum of 999.86 N" in log.attrs["warnings"][0]


@pytest.mark.parametrize("text", [
    "Extension at Maximum Load (mm),Tensile stress at Maximum Load (MPa)\n1.0,2.0\n\n",
    "Maximum Load : Energy at Maximum Load,1.5,J\nMaximum Load : Data point at Maximum Load,9,\n",
    "Maximum Load : Extension at Maximum Load,16.1250,mm\nLoad cell maximum,2000,N\n",
    "M\u00e1ximo Carga : TiempoalM\u00e1ximo Carga,3789.0,s\n",
])  # fmt: skip
def test_what_was_reached_at_maximum_load_is_no_maximum_load(text, tmp_path):
    assert read(tmp_path, text + HEAD + "\n".join(body()) + "\n")[0].attrs["warnings"] == []


@pytest.mark.parametrize("text", [
    "Maximum Load : Maximum Load,161.25,N\n", "M\u00e1ximo Carga : M\u00e1ximo Carga,161.25,N\n",
    "Maximum Compressive load [N],161.25\n", "H\u00f6chstkraft,161.25,N\n",
    "Force maximale (N),161.25\n",
])  # fmt: skip
def test_a_maximum_load_is_found_and_checked(text, tmp_path):
    log = read(tmp_path, text + "\n" + HEAD + "\n".join(body()) + "\n")[0]
    assert log.attrs["stated"] == {"maximum load": "161.25 N"}
    assert log.attrs["warnings"] == []
    with pytest.raises(instron.Unreadable, match="power of ten"):
        read(tmp_path, text.replace("161.25", "1.6125") + HEAD + "\n".join(body()) + "\n")


def test_a_table_without_header_is_read_when_told(tmp_path):
    text = "\n".join(row.split(",", 1)[1] for row in body())
    units = {"displacement": "mm", "force": "N"}
    log = read(tmp_path, text, columns=("displacement", "force"), units=units)[0]
    assert len(log) == 50
    assert log["force"].iloc[-1] == pytest.approx(161.25)
    assert log["time"].isna().all()


def test_quoted_line_breaks_in_the_preamble_do_not_shift_the_rows(tmp_path):
    log = read(tmp_path, 'Notes,"first\nsecond\nthird"\n\n' + HEAD + "\n".join(body()) + "\n")[0]
    assert len(log) == 50
    assert log["time"].iloc[0] == 0


def test_each_stacked_specimen_has_its_own_name(tmp_path):
    block = HEAD + "\n".join(body(30)) + "\n\n"
    logs = read(tmp_path, "".join(f"Specimen label,{name}\n{block}" for name in "abc"))
    assert [log.attrs["specimen"] for log in logs] == ["a", "b", "c"]


def test_ten_thousand_rows_of_garbage_do_not_hang(tmp_path):
    for garbage in (
        "a," * 100_000,
        "1" * 1_000_000,
        '"' * 100_000,
        "Time,Extension,Load\n" * 20_000,
    ):
        with pytest.raises(instron.Unreadable):
            read(tmp_path, garbage)


def test_a_row_cut_where_an_even_number_of_quotes_is_left_is_lost(tmp_path):
    rows = "".join(f'"{i}.5","{i}.25","{3 * i}.125"\n' for i in range(9))
    log = read(tmp_path, HEAD + rows + '9.5","9.25","2')[0]
    assert len(log) == 9
    assert log.attrs["lost_rows"] == 1
    with pytest.raises(instron.Unreadable, match="line 12: a quote"):
        read(tmp_path, HEAD + rows + '9.5","9.25","27.125\n"10.5","10.25","30.125"\n')


def test_a_marker_in_angle_brackets_is_no_xml(tmp_path):
    marked = "<Scan File>\n<INFO>\nRig:\t4\n<END INFO>\n<DATA>\n" + HEAD
    assert len(read(tmp_path, marked + "\n".join(body()) + "\n<END DATA>\n")[0]) == 50


def test_millions_of_mixed_marks_are_no_lost_decimal_point(tmp_path):
    """Several groups and a decimal mark: an English 1,629,770.853, a German 1.629.770,853."""
    values = [351.5, 219633.598, -883.087, 1629770.853, 988.603]
    english = "".join(f'{i}.5,{i}.25,"{value:,.3f}"\n' for i, value in enumerate(values))
    swap = str.maketrans(",.", ".,")
    german = "".join(f"{i},5;{i},25;{f'{v:,.3f}'.translate(swap)}\n" for i, v in enumerate(values))
    for text in (HEAD + english, HEAD.replace(",", ";") + german):
        np.testing.assert_array_equal(read(tmp_path, text)[0]["force"], values)


def test_footers_are_left_out(tmp_path):
    log = read(tmp_path, HEAD + "\n".join(body()) + "\n\nEnd of test\nOperator,Zoe\n")[0]
    assert len(log) == 50


def grouped(cell, remark="", *, german=False):
    """Return an export of forces with thousands, one of them replaced by this cell."""
    forces = ["247,953.97", cell, "1,861.92"]
    rows = [("Time (s)", "Extension (mm)", "Load (N)", "State", "Remark")]
    rows += [(f"0.{k}", f"0.2{k}", force, "100", remark) for k, force in enumerate(forces, 1)]
    if german:
        swap = str.maketrans(".,", ",.")
        return "".join(";".join(row).translate(swap) + "\n" for row in rows)
    return "".join(
        ",".join(f'"{one}"' if "," in one else one for one in row) + "\n" for row in rows
    )


@pytest.mark.parametrize("german", [False, True])
@pytest.mark.parametrize("cell", ["191,926.e3", "191,926.6E+3", "1,191,926.63e-2"])
def test_a_grouped_number_with_an_exponent_is_damage(tmp_path, cell, german):
    """A 6 that became an e made 1.9e8 of 191,926.63 without a word."""
    with pytest.raises(instron.Unreadable, match=r"line 3: '1[0-9.,eE+-]+' is not a number"):
        read(tmp_path, grouped(cell, german=german))


@pytest.mark.parametrize("german", [False, True])
def test_a_word_that_begins_with_e_behind_three_digits_is_no_exponent(tmp_path, german):
    log = read(tmp_path, grouped("191,926.63", "ended", german=german))[0]
    assert log["force"].tolist() == [247953.97, 191926.63, 1861.92]
