"""Random blocks and sheets: rows are in their test, in order, and every line has one role."""

import datetime
import io

import numpy as np
import openpyxl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

STEADY, SEARCH = settings.get_profile("steady"), settings.get_profile("search")


@st.composite
def block_files(draw):
    """Return a file of one test in blocks or of several tests, and how many tests it holds."""
    n, blocks = draw(st.integers(6, 30)), draw(st.integers(1, 5))
    runs_on = draw(st.booleans())
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    top = draw(st.sampled_from(["", "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n", "Operator\tZoe\n"]))
    between = draw(st.sampled_from(["", "\n", "Data Acquisition\tTime:\t5.0\ts\n", "Buffer\n\n"]))
    tail = draw(st.sampled_from(["", "\n\n", "End of test\n", "0\t0\t0\n"]))
    rows, text = [], top
    for block in range(blocks):
        start = block * n if runs_on else 0
        t = np.round((start + np.arange(n)) * 0.1, 1)
        block_rows = np.column_stack(
            [t, np.round(t * 0.25 + 0.5, 4), np.round(rng.uniform(1, 9, n), 3)]
        )
        text += between + "Time\tPosition\tForce\ns\tmm\tN\n"
        text += "".join("\t".join(map(str, row)) + "\n" for row in block_rows)
        rows.append(block_rows)
    return text + tail, rows, 1 if runs_on else blocks


def check_blocks(drawn, attempt):
    """Rows are in their test, in order; every line of the file has one role."""
    text, rows, tests = drawn
    logs = attempt(text.encode())
    assert logs is not None
    assert len(logs) == tests
    assert sum(logs[0].attrs["lines"].values()) == text.count("\n")
    whole = np.concatenate(rows)
    read = np.concatenate([log[["time", "displacement", "force"]].to_numpy() for log in logs])
    np.testing.assert_allclose(read, whole * [1, 1e-3, 1], rtol=1e-12)
    assert logs[0].attrs["lines"]["data"] == len(whole)


@st.composite
def sheets(draw):
    """Return cells of a sheet of numbers, one of which may be something else."""
    n = draw(st.integers(3, 15))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    digits = draw(st.sampled_from([0, 1, 3, 4, 12]))
    numbers = np.round(np.cumsum(rng.uniform(0.01, 900, (n, 3)), axis=0), digits)
    rows = [["Time", "Extension", "Load"], ["s", "mm", "N"], *numbers.tolist()]
    odd = draw(st.sampled_from([None, None, "OVER", "1,5", datetime.date(2021, 3, 4), "", True]))
    if odd is not None:
        rows[2 + draw(st.integers(0, n - 1))][draw(st.integers(0, 2))] = odd
    return rows, numbers, odd


def check_sheet(drawn, attempt):
    rows, numbers, odd = drawn
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    stream = io.BytesIO()
    book.save(stream)
    logs = attempt(stream.getvalue())
    if odd is None:
        assert logs is not None
        np.testing.assert_allclose(logs[0][["time", "displacement", "force"]].to_numpy(),
                                   numbers * [1, 1e-3, 1], rtol=1e-12)  # fmt: skip
    elif logs is not None:  # what is not a number may at most have cost the last row
        assert logs[0].attrs["warnings"]
        assert len(logs[0]) < len(numbers)


@settings(STEADY, max_examples=250)
@given(drawn=block_files())
def test_random_blocks_are_joined_or_kept_apart(drawn, attempt):
    check_blocks(drawn, attempt)


@settings(STEADY, max_examples=60)
@given(drawn=sheets())
def test_random_sheets_are_read_or_refused(drawn, attempt):
    check_sheet(drawn, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=3000)
@given(drawn=block_files())
def test_many_random_blocks(drawn, attempt):
    check_blocks(drawn, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=1000)
@given(drawn=sheets())
def test_many_random_sheets(drawn, attempt):
    check_sheet(drawn, attempt)
