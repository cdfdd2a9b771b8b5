"""Quotes taken off a whole body at once, against a reader of one line at a time."""

import csv
import io
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instron import Unreadable, read
from instron.numbers import bits
from instron.numbers.quotes import enclosed_commas
from instron.source.stream import Unquoted

CELL = st.one_of(
    st.floats(0, 3e6).map("{:.2f}".format),
    st.floats(0, 3e6).map('"{:,.2f}"'.format),
    st.floats(0, 3e6).map('"{:.1f}"'.format),
)
ROWS = st.lists(st.lists(CELL, min_size=2, max_size=2), min_size=1, max_size=60)


def body(rows):
    return "".join(",".join(row) + "\n" for row in rows).encode()


@pytest.mark.parametrize("size", [64, 1 << 19])
@settings(max_examples=150, deadline=None, derandomize=True)
@given(rows=ROWS, start=st.integers(0, 70))
def test_commas_in_quotes_are_those_within_its_cells(size, rows, start):
    data = b"#" * start + body(rows)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bits, "SIZE", size)
        found = enclosed_commas(data, start, ",")
        words = np.concatenate([piece[1:-1] for piece in found])
        stripped = Unquoted(io.BytesIO(data[start:]), found)
        text = b"".join(iter(lambda: stripped.read(130), b"")).decode()
    flags = np.unpackbits(words.view(np.uint8), bitorder="little")
    cells = [match.span() for match in re.finditer(rb'"[^"]*"', data[start:])]
    inside = [i for a, b in cells for i in range(a, b) if data[start + i : start + i + 1] == b","]
    assert list(np.flatnonzero(flags)) == inside
    by_line = csv.reader(io.StringIO(body(rows).decode()))
    assert [row.split(",") for row in text.splitlines()] == [
        [cell.replace(",", "") for cell in row] for row in by_line
    ]


@pytest.mark.parametrize(
    "line",
    ['1.0,"2.0"5', '1.0,2"5.0"', '1.0,"2.0', '"1.0\n2.0",3.0', '""1.0"",2.0', '1.0,"2.""0"'],
)
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_quotes_out_of_order_are_a_doubt(line, delimiter):
    for before in (0, 1, 40):
        text = "0.5,0.25\n" * before + line + "\n" + '"0.5",0.25\n' * before
        data = text.replace(",", delimiter).encode()
        assert enclosed_commas(data, 0, delimiter) is None


def test_a_delimiter_within_quotes_is_a_doubt_unless_a_comma():
    assert enclosed_commas(b'"1;5";2.0\n', 0, ";") is None
    assert enclosed_commas(b'"1\t5"\t2.0\n', 0, "\t") is None
    assert enclosed_commas(b'"1,5";2.0\n', 0, ";") is not None


def test_a_line_break_in_quotes_makes_no_two_rows(tmp_path):
    """Cells before and after it would fill both."""
    path = tmp_path / "export.csv"
    rows = "".join(f'"{k}.5","{k}.25","{k}.75"\n' for k in range(30))
    path.write_text("Time (s),Extension (mm),Load (N)\n" + rows + '30.5,30.25,"30.75\n31.5",1,2\n')
    with pytest.raises(Unreadable, match="line 32"):
        read(path)
