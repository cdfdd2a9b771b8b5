"""Cables that change colour along themselves are one; seams are none; guesses are said to be."""

import numpy as np
import pytest
from drawn.tables import GROUNDS, draw_table
from scipy.spatial import cKDTree

from imaging import Photo, Unmeasurable, segment, trace
from imaging.segment.crests import Piece, stands_out
from imaging.segment.lattice import of_lattice
from imaging.segment.naming import named


def piece(line, colour=(50.0, 0, 0)) -> Piece:
    return Piece(np.asarray(line, float), np.array(colour), np.zeros(3), 8.0, 20.0)


def followed(table) -> list[float]:
    """Share of each cable's length that its best strand covers."""
    photo = Photo(table.pixels)
    strands = [cKDTree(s.line) for s in trace(segment(photo), photo)]
    return [
        max((s.query(line)[0] < 1.3 * radius).mean() for s in strands)
        for line, radius in zip(table.lines, table.radii, strict=True)
    ]


@pytest.mark.parametrize("make", ["striped", "banded", "plied", "fuzzy", "glossy"])
def test_a_cable_of_any_make_is_one_strand(make):
    share = followed(draw_table("cloth", 1002, makes=(make,)))
    assert np.mean(np.array(share) > 0.85) >= 0.75


def test_a_longer_ridge_needs_to_stand_out_less():
    assert stands_out(20.0, 5 * 8, 8)
    assert not stands_out(10.0, 5 * 8, 8)
    assert stands_out(10.0, 50 * 8, 8)
    assert not stands_out(7.0, 500 * 8, 8)


def lattice(step: int) -> list[Piece]:
    """Straight pieces between the crossings of upright and level lines, 400 x 300 px."""
    level = [[(x, y) for x in range(x0 + 4, x0 + step - 4)]
             for y in range(20, 300, step) for x0 in range(0, 400, step)]  # fmt: skip
    upright = [[(x, y) for y in range(y0 + 4, y0 + step - 4)]
               for x in range(20, 400, step) for y0 in range(0, 300, step)]  # fmt: skip
    return [piece(line) for line in level + upright]


def test_seams_are_a_lattice_and_strands_over_them_are_not():
    s = np.arange(300)
    strand = piece(np.stack([30 + s, 150 + 60 * np.sin(s / 40)], axis=1))
    other = piece(np.stack([30 + s, 60.0 + 0 * s], axis=1), colour=(70, 40, 10))
    pieces, _ = named([*lattice(50), strand, other])
    assert of_lattice(pieces, (300, 400)).tolist() == [True] * (len(pieces) - 2) + [False, False]


def test_a_few_straight_strands_that_cross_are_no_lattice():
    pieces, _ = named(lattice(200))
    assert not of_lattice(pieces, (300, 400)).any()


def test_colours_are_named_after_pieces():
    line = [(x, 5) for x in range(50)]
    shades = [(50, 0, 0), (54, 3, 0), (50, 60, 20), (52, 58, 22), (90, 0, 0)]
    pieces, colours = named([piece(line, colour=shade) for shade in shades])
    tones = [p.tone for p in pieces]
    assert tones[0] == tones[1]
    assert tones[2] == tones[3]
    assert len(set(tones)) == len(colours) == 3


@pytest.mark.parametrize("ground", ["gravel", "grass", "cloth", "card"])
def test_texture_alone_has_no_strand(ground):
    bare = GROUNDS[ground]((300, 400), np.random.default_rng(5))
    pixels = np.round(255 * np.clip(bare, 0, 1) ** (1 / 2.2)).astype(np.uint8)
    try:
        strands = trace(segment(Photo(pixels)))
    except Unmeasurable:
        strands = []
    assert strands == []
