"""Link on both sides of a tine, on pairs whose answer is known."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import imaging
import sim
from combing.compare.link_change import changes
from combing.errors import UserError
from combing.study import LinkSet
from combing.tables import read_table
from combing.unlinking import combing_ends, link_change, link_facts, link_history, tine_place
from combing.virtual_lab.photographs import smooth
from imaging.scale import from_marker

DATA = Path(__file__).parents[2] / "data"
PITCH, R, TURNS = 0.008, 4e-4, 12
HEIGHT = PITCH * TURNS


def pair(combed=0.0, tight=1.0):
    """Hang a double helix whose upper part is straight, the rest `tight` times as wound."""
    z = np.linspace(0, HEIGHT, 600)
    phase = 2 * np.pi / PITCH * tight * np.maximum(z - combed, 0)
    line = np.column_stack([R * np.cos(phase), -R * np.sin(phase), -z])
    return [line, line * [-1, -1, 1]]


class Combing:
    """A made run: the tine unlinks what it passes, and ahead lambda grows by a tenth till d = D."""

    D = 0.08

    def __init__(self, tight=lambda d: 1.0 + d, handed=1.0):
        self.displacements = np.linspace(0, 0.1, 26)
        self.data = SimpleNamespace(attrs={"title": "made"})
        tine = SimpleNamespace(
            position=(0, 0, 0), direction=(0, 0, -1), axis=(0, 1, 0), radius=1e-4
        )
        rod = SimpleNamespace(radius=R, material=SimpleNamespace(E=1e9))
        self.scene = SimpleNamespace(tines=[tine], rods=[rod, rod])
        self._tight, self._handed = tight, handed

    def strands(self, snapshot=-1):
        d = self.displacements[snapshot]
        return [one * [1, self._handed, 1] for one in pair(d, self._tight(d) if d else 1.0)]

    def force_log(self):
        d = np.linspace(0, 0.1, 2001)
        force = np.where(d < self.D, 0.2 + 2 * d, 0.0) * (d > 0)
        log = pd.DataFrame({"time": d, "displacement": d, "force": force})
        log.attrs = {"r": R, "E": 1e9, "specimen": "made", "kind": "simulation", "source": "made"}
        return log


@pytest.mark.parametrize("handed", [1.0, -1.0])
def test_the_jump_is_what_was_wound(handed):
    """Behind nothing is linked, ahead 1.25 times the first density: the jump is 1.25."""
    history = link_history(Combing(lambda d: 1.25, handed))
    inside = history[(history["x"] > 0.1) & (history["x"] < 0.7)]
    assert history.attrs["lambda_0"] * handed == pytest.approx(1 / PITCH, rel=0.03)
    assert inside["jump"].to_numpy() == pytest.approx(1.25, rel=0.06)
    assert inside["behind"].abs().max() < 0.1 / PITCH
    assert inside["tine"].to_numpy() == pytest.approx(inside["d"].to_numpy(), abs=PITCH)
    expected = 0.25 / PITCH * (HEIGHT - inside["d"])
    assert inside["excess"].to_numpy() == pytest.approx(expected.to_numpy(), rel=0.1, abs=0.2)


def test_the_force_is_that_of_the_log_and_x_that_of_its_end():
    run = Combing()
    history = link_history(run)
    assert combing_ends(run) == pytest.approx(run.D, rel=0.02)
    middle = history[(history["x"] > 0.2) & (history["x"] < 0.9)]
    assert middle["force"].to_numpy() == pytest.approx(0.2 + 2 * middle["d"].to_numpy(), rel=0.01)
    assert history["x"].max() <= 1
    assert len(link_history(run, shots=5)) <= 7


def test_the_change_is_nothing_before_and_minus_one_behind_the_tine():
    table = link_change(Combing(lambda d: 1.5), [0.0, 0.04])
    assert table.loc[table["d"] == 0, "change"].abs().median() < 0.03
    combing = table[table["d"] == 0.04]
    assert combing.loc[combing["s"] < 0.03, "change"].to_numpy() == pytest.approx(-1, abs=0.05)
    ahead = combing[(combing["s"] > 0.05) & (combing["s"] < 0.08)]
    assert ahead["change"].to_numpy() == pytest.approx(0.5, abs=0.06)


def test_the_tine_is_where_the_strands_meet_it_first():
    """A kink that comes near the tine's axis again further on is not taken for it."""
    run = Combing()
    first, second = pair(0.0)
    kinked = [one.copy() for one in (first, second)]
    for one in kinked:
        one[400:410] += np.array([0, 0.02, 0]) + (np.array([0, 0, -0.03]) - one[405]) * [0, 0, 1]
    assert tine_place(run, 0.03, *kinked, TURNS) == pytest.approx(0.03, abs=1e-3)


@pytest.mark.parametrize(("apart", "first"), [(1.4, True), (1.6, False)])
def test_a_strand_is_met_where_it_is_within_half_a_touching_distance_of_the_tine(apart, first):
    """It goes down `apart` touching distances beside the tine, and up through it again."""
    run = Combing()
    aside = apart * (run.scene.tines[0].radius + run.scene.rods[0].radius)
    z = np.linspace(0, 0.06, 601)
    down = np.column_stack([0 * z + aside, 0 * z, -z])
    strand = np.concatenate([down, down[::-1] * [0, 1, 1]])
    assert (tine_place(run, 0.03, strand, strand, 0.0) < 0.06) == first


def test_a_history_looks_at_some_thirty_snapshots_of_a_long_run():
    run = Combing()
    run.displacements = np.linspace(0, 0.1, 251)
    assert 32 <= len(link_history(run)) <= 40


def test_facts_leave_out_how_the_force_rises_before_the_tine_moves():
    """What happens on the first fiftieth of the stroke decides nothing; on the next it does."""
    x = np.array([0.0, 0.01, 0.019, 0.03, 0.1, 0.2, 0.4, 0.8])
    history = pd.DataFrame({"x": x, "force": x, "excess": x, "near": 100 + x})
    history = history.assign(jump=0.5, stays=20.0, turns=20.0)
    history.attrs = {"lambda_0": 100.0}
    history.loc[:2, "force"] = 9.0
    assert link_facts(history, [])["force_and_excess"] == pytest.approx(1)
    history.loc[3, "force"] = 9.0
    assert link_facts(history, [])["force_and_excess"] < 0.5


def test_direction_and_axis_of_the_tine_may_have_any_length():
    run = Combing()
    places = [tine_place(run, 0.03, *pair(0.0), TURNS)]
    run.scene.tines[0].direction, run.scene.tines[0].axis = (0, 0, -2), (0, 3, 0)
    places.append(tine_place(run, 0.03, *pair(0.0), TURNS))
    assert places[0] == places[1]


def test_facts_of_a_history_that_is_known():
    x = np.linspace(0, 1, 201)
    history = pd.DataFrame({"x": x, "force": x, "excess": x**2, "near": 100 + 50 * x})
    history = history.assign(jump=np.minimum(x, 0.6), stays=20.0, turns=20 - 19 * x)
    history.attrs = {"lambda_0": -100.0}
    facts = link_facts(history, [0.902])
    assert facts["force_and_excess"] == pytest.approx(1)
    assert facts["most_excess"] == pytest.approx(1)
    assert facts["below_jams"] == pytest.approx(0.9, abs=0.01)
    assert facts["jump_growth"] == pytest.approx(0.375, abs=0.01)
    assert facts["jump_change"] == pytest.approx(0.6 / 0.575 - 1, abs=0.01)
    assert facts["behind"] == pytest.approx(0.2)
    assert facts["expelled"] == pytest.approx(0.95)
    assert np.isnan(link_facts(history, [])["below_jams"])
    assert np.isnan(link_facts(history[history["x"] < 0.02], [0.902])["below_jams"])


def test_what_is_no_combing_of_a_pair_is_refused():
    run = Combing()
    run.scene.tines = []
    with pytest.raises(UserError, match="made: 2 strands and 0 tines"):
        link_history(run)


def test_changes_of_photographs_are_relative_to_the_one_before():
    before, seen = (
        pd.DataFrame({"s": [0.01, 0.02], "link": link, "sd": [5.0, 5.0]})
        for link in ([90.0, 90.0], [50.0, 130.0])
    )
    asked = []

    def jump(lambda_0):
        asked.append(lambda_0)
        return {"tine": 0.018, "reach": 0.0025, "behind": 40.0, "behind_sd": 3.0, "jump": 0.8,
                "jump_sd": 0.05}  # fmt: skip

    before.attrs["first"], seen.attrs["jump"] = (100.0, 1.0), jump
    chosen = LinkSet.model_construct(name="a", combed=0.1)
    table = changes(chosen, before, [seen], [0.03], None).set_index("curve")
    assert asked == [(100.0, 1.0)]
    assert list(table.loc["profile", "change"]) == pytest.approx([-0.5, 0.3])
    assert list(table.loc["profile", "sd"]) == pytest.approx([0.05, 0.05])
    assert table.loc["jump", ["x", "change", "sd"]].tolist() == pytest.approx([0.3, 0.8, 0.05])
    assert set(table.index) == {"profile", "jump"}  # behind the tine, too, the profile says it


def test_without_a_photograph_before_the_first_one_is_the_reference():
    none = {"jump": np.nan, "behind": np.nan}
    seen = [pd.DataFrame({"s": [0.01], "link": [link], "sd": [5.0]}) for link in (80.0, 120.0)]
    for one in seen:
        one.attrs = {"first": (one["link"].item(), 1.0), "jump": lambda lambda_0: none}
    run = Combing(lambda d: 1.25)
    chosen = LinkSet.model_construct(name="a", combed=0.1)
    table = changes(chosen, None, seen, [0.0, 0.03], run)
    own = table[table["source"] == "experiment"]
    assert own["change"].tolist() == pytest.approx([0.0, 0.5])
    jumps = table[(table["source"] == "simulation") & (table["curve"] == "jump")]
    history = link_history(run, shots=None)
    np.testing.assert_allclose(jumps["change"], history["jump"])
    np.testing.assert_allclose(jumps["d"], history["d"])
    assert (table.loc[table["source"] == "simulation", "sd"] == 0).all()


class Photographed(Combing):
    """The run that the virtual lab photographed, before the tine and at its fourth place."""

    def __init__(self):
        super().__init__()
        self.scene = sim.load_scene(DATA / "scenes" / "double_helix.toml")
        places = read_table(DATA / "photos" / "synthetic_helix_positions.csv", ["photo", "d"])
        there = places.loc[places["photo"] == "synthetic_helix_4.jpg", "d"]
        self.displacements = np.array([0.0, float(there.iloc[0])])

    def strands(self, snapshot=-1):
        shot = ("synthetic_helix_before", "synthetic_helix_4")[snapshot]
        with np.load(DATA / "truth" / "synthetic_strands.npz") as truth:
            return [smooth(truth[f"{shot}/{number}"]) for number in (1, 2)]


def test_a_run_and_its_photographs_have_the_same_jump():
    photographed = {}
    for shot in ("before", "4"):
        picture = imaging.read_photo(DATA / "photos" / f"synthetic_helix_{shot}.jpg")
        scale, photo = from_marker(picture, 0.008)
        photographed[shot] = imaging.helix(photo, scale=scale)
    history = link_history(Photographed())
    before = imaging.first_link(photographed["before"])
    seen = imaging.link_jump(photographed["4"], before)
    assert abs(before[0] - history.attrs["lambda_0"]) < 1.96 * before[1]
    there = history.iloc[-1]
    for side in ("behind", "ahead", "jump"):
        assert abs(seen[side] - there[side]) < 1.96 * seen[f"{side}_sd"]
    assert there["jump"] == pytest.approx(1.353, abs=0.01)  # by the strands' topology
    assert seen["jump_sd"] < 0.35
