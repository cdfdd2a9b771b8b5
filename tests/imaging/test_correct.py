"""Corrections by hand: each step against the truth, replayed on other measurements, misfits."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from drawn.waves import off, scene, waves
from hypothesis import given, settings
from hypothesis import strategies as st

import imaging
from imaging import Corrections, Unmeasurable, crossings
from imaging.correct import correct, put_on_top
from imaging.correct.anchors import direction, place_on
from imaging.correct.schema import (
    Anchor,
    Delete,
    Draw,
    Exchange,
    Join,
    Only,
    Photograph,
    Split,
    Top,
    Way,
)
from imaging.correct.steps import ALREADY, APPLIED, MISFIT


def applied(*steps, strands=None, **said):
    photo, segmentation, found = scene()
    corrections = Corrections(steps=list(steps), **said)
    given_strands = found if strands is None else strands
    made, hand = correct(photo, segmentation, given_strands, corrections)
    return made, hand, [one.outcome for one in hand.outcomes]


def anchor(strand, at, sign=1):
    return Anchor(at=tuple(strand.line[at]), along=tuple(sign * direction(strand, at)))


def line_of(strand, every=15):
    return [tuple(point) for point in strand.line[::every]]


def split_and_joined(strand, at):
    """Part a strand at one of its points and join it again."""
    return (
        Split(here=anchor(strand, at)),
        Join(start=anchor(strand, at), to=anchor(strand, at + 1, -1)),
    )


@given(at=st.integers(20, 200), which=st.integers(0, 2))
@settings(max_examples=25, deadline=None)
def test_split_and_join_is_identity(at, which):
    before = scene()[2]
    made, hand, outcomes = applied(*split_and_joined(before[which], at))
    assert outcomes == [APPLIED, APPLIED]
    assert hand.by[which] == "joined"
    for one, other in zip(made, before, strict=True):
        for name in ("line", "width", "sd", "edges", "tones", "doubts"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert one.ends == other.ends


@given(which=st.integers(0, 2), others=st.permutations(range(3)))
@settings(max_examples=12, deadline=None)
def test_a_strand_deleted_is_gone_and_drawn_again_is_back(which, others):
    strands = [scene()[2][i] for i in others]
    gone = scene()[2][which]
    made, _, outcomes = applied(Delete(line=line_of(gone)), strands=strands)
    assert outcomes == [APPLIED]
    assert [id(s) for s in made] == [id(s) for s in strands if s is not gone]
    made, hand, _ = applied(
        Delete(line=line_of(gone)), Draw(points=line_of(gone, 30)), strands=strands
    )
    assert sorted(hand.by) == ["", "", "drawn"]
    assert off(made[-1].line, waves()[which]).mean() < 0.4
    assert made[-1].colour == gone.colour


def test_a_line_drawn_by_an_unsteady_hand_is_set_on_the_strand():
    photo, segmentation, found = scene()
    truth = waves()[1]
    rng = np.random.default_rng(5)
    rough = truth[::25] + rng.normal(0, 1.5, truth[::25].shape)
    made, _, _ = applied(Draw(points=[tuple(p) for p in rough]), strands=found[:1])
    drawn = made[-1]
    assert np.sqrt((off(drawn.line, truth) ** 2).mean()) < 0.5
    assert np.median(drawn.width) == pytest.approx(np.median(found[1].width), rel=0.02)
    assert (drawn.edges == 2).mean() > 0.6


def test_what_is_drawn_takes_over_its_pieces():
    first = scene()[2][0]
    parts, _, _ = applied(Split(here=anchor(first, 100)))
    assert len(parts) == 4
    rough = [tuple(p) for p in waves()[0][::20]]  # a piece of 40 % is left out, one of 60 % too
    made, _, outcomes = applied(Draw(points=rough), strands=parts)
    assert outcomes == [APPLIED]
    assert len(made) == 3


def exchanged_at(a, b, crossing, ahead=20):
    """Step that lets two strands go on as each other at a crossing, in the forward sense."""
    i, j = (int(np.hypot(*(s.line - crossing).T).argmin()) for s in (a, b))
    return Exchange(
        at=tuple(crossing),
        ways=(
            Way(start=anchor(a, i - ahead), to=anchor(b, j + ahead)),
            Way(start=anchor(b, j - ahead), to=anchor(a, i + ahead)),
        ),
    )


def test_exchange_once_is_a_swap_and_said_again_is_so_already():
    strands = scene()[2]
    table = crossings(strands)
    inside = table["s_a"].between(40, 200) & (table["strand_a"] == 1) & (table["strand_b"] == 2)
    row = table[inside].iloc[0]
    step = exchanged_at(strands[0], strands[1], row[["x", "y"]].to_numpy(float))
    made, hand, outcomes = applied(step)
    assert outcomes == [APPLIED]
    assert hand.by == ["exchanged", "exchanged", ""]
    roots = [one.line[0] for one in made[:2]]
    tips = [one.line[-1] for one in made[:2]]
    np.testing.assert_allclose(sorted(map(tuple, roots)),
                               sorted(tuple(s.line[0]) for s in strands[:2]), atol=1)  # fmt: skip
    for root, tip in zip(roots, tips, strict=True):
        own = int(np.argmin([np.hypot(*(s.line[0] - root)) for s in strands[:2]]))
        assert np.hypot(*(strands[1 - own].line[-1] - tip)) < 1
    again, _, outcomes = applied(step, strands=made)
    assert outcomes == [ALREADY]
    assert [id(s) for s in again] == [id(s) for s in made]


@given(
    order=st.permutations(range(3)),
    shift=st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
    flip=st.booleans(),
)
@settings(max_examples=20, deadline=None)
def test_steps_are_replayed_on_another_measurement(order, shift, flip):
    """Another program numbers strands otherwise and places them a pixel aside."""
    strands = scene()[2]
    moved = [replace(strands[i], line=strands[i].line + shift) for i in order]
    steps = (
        Delete(line=line_of(strands[0])),
        Split(here=anchor(strands[1], 90, -1 if flip else 1)),
    )
    made, hand, outcomes = applied(*steps, strands=moved)
    assert outcomes == [APPLIED, APPLIED]
    assert len(made) == 3
    whole = [s.line[0] for s, by in zip(made, hand.by, strict=True) if not by]
    np.testing.assert_allclose(whole, [strands[2].line[0] + shift])


def test_what_no_longer_fits_is_told_and_changes_nothing():
    strands = scene()[2]
    nowhere = Anchor(at=(5, 5), along=(1, 0))
    across = Anchor(
        at=tuple(strands[0].line[90]), along=tuple(direction(strands[0], 90)[::-1] * [1, -1])
    )
    steps = (
        Split(here=nowhere),
        Split(here=across),
        Join(start=nowhere, to=anchor(strands[0], 0, -1)),
        Exchange(at=(5, 5), ways=(Way(start=nowhere, to=nowhere), Way(start=nowhere, to=nowhere))),
    )
    made, hand, outcomes = applied(*steps)
    assert outcomes == [MISFIT] * 4
    assert [id(s) for s in made] == [id(s) for s in strands]
    notes = hand.notes()
    assert notes[0] == "corrected by hand: nothing"
    assert len(notes) == 5
    assert "(5, 5)" in notes[1]


def test_a_strand_that_grew_is_not_deleted_with_the_piece_it_was():
    strands = scene()[2]
    piece = [tuple(p) for p in strands[0].line[:100:10]]
    made, _, outcomes = applied(Delete(line=piece))
    assert outcomes == [MISFIT]
    assert len(made) == 3
    assert applied(Delete(line=[(3, 3), (3, 40)]))[2] == [ALREADY]


def test_the_neighbour_of_a_strand_is_not_deleted_with_it():
    strand = scene()[2][0]
    neighbour = replace(strand, line=strand.line + [2.5, 0])  # much nearer than they are wide
    made, _, outcomes = applied(Delete(line=line_of(strand)), strands=[neighbour, strand])
    assert outcomes == [APPLIED]
    assert made == [neighbour]


def test_a_strand_drawn_beside_another_drawn_one_leaves_it():
    lines = [[tuple(p) for p in waves()[0][::20] + [shift, 0]] for shift in (0, 2)]
    made, hand, outcomes = applied(*(Draw(points=line) for line in lines), strands=[])
    assert outcomes == [APPLIED, APPLIED]
    assert hand.by == ["drawn", "drawn"]


def test_joined_already_and_drawn_already():
    strands = scene()[2]
    join = Join(start=anchor(strands[0], 80), to=anchor(strands[0], 100, -1))
    made, _, outcomes = applied(join, Draw(points=line_of(strands[2])))
    assert outcomes == [ALREADY, ALREADY]
    assert [id(s) for s in made] == [id(s) for s in strands]


def test_top_is_swapped_and_unknown():
    photo, segmentation, strands = scene()
    table = crossings(strands, segmentation)
    steps, expected = [], []
    for row, known in zip(table.head(2).to_dict("records"), (True, False), strict=True):
        under = row["over"]
        over = row["strand_a"] + row["strand_b"] - under
        here = (row["x"], row["y"])
        along = [tuple(direction(s, place_on(s, here)[0]))
                 for s in (strands[over - 1], strands[under - 1])]  # fmt: skip
        steps.append(Top(at=(row["x"] + 1, row["y"]), over=along[0], under=along[1], known=known))
        expected.append(over if known else pd.NA)
    steps.append(Top(at=(3, 3), over=(1, 0), under=(0, 1)))
    made, hand = correct(photo, segmentation, strands, Corrections(steps=steps))
    after = put_on_top(table, made, hand)
    assert after["over"].iloc[0] == expected[0]
    assert after["over"].iloc[1] is pd.NA
    assert list(after["over_by"].iloc[:3]) == ["hand", "hand", ""]
    assert after["confidence"].iloc[0] == 1
    assert [one.outcome for one in hand.outcomes] == [APPLIED, APPLIED, MISFIT]
    pd.testing.assert_frame_equal(after.iloc[2:, :10], table.iloc[2:])


def test_only_these_lines_are_strands():
    strands = scene()[2]
    lines = [line_of(strands[2]), [tuple(p) for p in waves()[0][::20]]]
    made, hand, outcomes = applied(Only(lines=lines), strands=strands[1:])
    assert outcomes == [APPLIED]
    assert hand.by == ["", "drawn"]
    assert made[0] is strands[2]
    assert off(made[1].line, waves()[0]).mean() < 0.4


def test_the_number_joins_pieces_and_leaves_out_scraps():
    strands = scene()[2]
    parts, _, _ = applied(Split(here=anchor(strands[1], 120)))
    gap = [replace(p, **{n: getattr(p, n)[: len(p.line) - 12]
                         for n in ("line", "width", "sd", "edges", "tones")})
           if p is parts[1] else p for p in parts]  # fmt: skip
    made, hand, outcomes = applied(strands=gap)
    made, hand = correct(scene()[0], scene()[1], gap, Corrections(strands=3))
    assert hand.outcomes[0].outcome == APPLIED
    assert max(off(made[1].line, waves()[1])) < 3
    assert hand.by == ["", "joined", ""]
    _, hand = correct(scene()[0], scene()[1], strands, Corrections(strands=5))
    assert hand.outcomes[0].outcome == MISFIT
    assert "3 there" in hand.outcomes[0].why


def shown(photo, strand):
    x, y = np.rint(strand.line).astype(int).T
    return "#" + "".join(f"{v:02x}" for v in np.median(photo.pixels[y, x], axis=0).astype(int))


def test_named_colours_leave_out_the_others():
    photo, segmentation, strands = scene()
    red, green, blue = (shown(photo, strand) for strand in strands)
    made, _ = correct(photo, segmentation, strands, Corrections(colours=[red, green]))
    assert [id(s) for s in made] == [id(s) for s in strands[:2]]
    made, _ = correct(photo, segmentation, strands, Corrections(ground=[blue]))
    assert [id(s) for s in made] == [id(s) for s in strands[:2]]
    with pytest.raises(Unmeasurable, match="leave no strand"):
        correct(photo, segmentation, strands, Corrections(colours=["#ffff00"]))


def test_corrections_of_another_size_are_refused():
    said = Corrections(photograph=Photograph(name="waves.png", width=10, height=20))
    with pytest.raises(Unmeasurable, match="10 x 20"):
        correct(*scene(), said)


def test_measure_tells_what_a_hand_did():
    photo = scene()[0]
    gone = scene()[2][0]
    said = Corrections(steps=[Delete(line=line_of(gone))], strands=2)
    found = imaging.measure(photo, corrections=said)
    assert len(found.strands) == 2
    assert found.hand.applied == 1
    assert found.notes[0] == "corrected by hand: 1 delete; 1 as measured already"
    assert imaging.measure(photo, corrections=None).hand.outcomes == []
