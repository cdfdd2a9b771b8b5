"""Marks of thousands found in bits, against a reader of one number at a time."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instron.numbers import bits
from instron.numbers.marks import marks_of
from instron.numbers.quotes import enclosed_commas

LARGE = {
    ",": re.compile(r"[1-9]\d{0,2}(?:,\d{3})+\.[\d.]*"),
    ".": re.compile(r"[1-9]\d{0,2}(?:\.\d{3})+,[\d,]*"),
}


def grouped(cells, mark):
    """Tell whether a mark groups the thousands of every large number, one number at a time.

    What is no number at all is left to who converts them.
    """
    other = "." if mark == "," else ","
    large = [cell for cell in cells if mark in cell]
    return (
        bool(large)
        and all(LARGE[mark].fullmatch(cell) for cell in large)
        and not any(re.search(rf"(?<![\d{other}])\d{{4}}", cell) for cell in cells)
    )


NUMBER = st.one_of(
    st.floats(0, 3e6).map("{:,.3f}".format),
    st.floats(0, 900).map("{:.2f}".format),
    st.text("0123456789.,", min_size=1, max_size=9),
)


@settings(max_examples=400, deadline=None, derandomize=True)
@given(st.lists(NUMBER, min_size=1, max_size=60), st.booleans())
def test_thousands_are_those_of_a_reader_number_by_number(cells, german):
    if german:
        cells = [cell.translate(str.maketrans(",.", ".,")) for cell in cells]
    text = "\n".join(["head", "a;b", *(f"{c};1{',' if german else '.'}0" for c in cells), ""])
    found = marks_of(text.encode(), text.index("\n", 5) + 1, ";")
    mark = "." if german else ","
    if found is not None and found[1] is not None:
        assert grouped(cells, found[1])
    elif grouped(cells, mark):
        assert found is None, "thousands were not seen"


def in_quotes(data, start):
    return marks_of(data, start, ",", enclosed_commas(data, start, ","))


@pytest.mark.parametrize("size", [64, 1 << 19])
def test_pieces_do_not_change_what_is_found(size, monkeypatch):
    monkeypatch.setattr(bits, "SIZE", size)
    rng = np.random.default_rng(3)
    values = rng.uniform(0, 2e6, 500)
    rows = [f'{v / 7e4:.2f},"{v:,.2f}"' if v > 1e3 else f"{v:.2f},{v:.2f}" for v in values]
    start = b"Time,Load\n"
    data = start + "\n".join(rows).encode() + b"\n"
    assert in_quotes(data, len(start)) == (".", ",")
    broken = data.replace(b",00", b",0", 1).replace(b",1", b",01", 1)
    assert in_quotes(broken, len(start)) is None
    plain = data.replace(f'"{values[-1]:,.2f}"'.encode(), f"{values[-1]:.2f}".encode())
    assert in_quotes(plain, len(start)) is None


@given(st.lists(st.booleans(), min_size=128, max_size=128), st.integers(-9, 9).filter(bool))
def test_a_shift_of_bits_is_a_shift_of_flags(flags, offset):
    flags = np.array(flags)
    moved = np.unpackbits(bits.at(bits.bits(flags), offset).view(np.uint8), bitorder="little")
    assert [int(flags[i + offset]) if 0 <= i + offset < 128 else 0 for i in range(128)] == list(
        moved
    )


@given(st.lists(st.booleans(), min_size=192, max_size=192), st.booleans())
def test_what_is_within_quotes_is_their_parity(quotes, opened):
    quotes = np.array(quotes)
    inside, after = bits.within(bits.bits(quotes), opened)
    state, truth = opened, []
    for quote in quotes[64:]:
        state ^= bool(quote)
        truth.append(state)
    found = np.unpackbits(inside.view(np.uint8), bitorder="little")[64:]
    assert list(found) == truth
    assert after == truth[63]
