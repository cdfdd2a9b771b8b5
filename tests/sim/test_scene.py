"""Scenes: what is refused and how, and what the presets draw."""

import subprocess
import sys

import numpy as np
import pytest

import sim
from sim.explicit import Explicit, explicit
from sim.march.state import build
from sim.scene import Scene
from sim.scene.shapes import random_curvature

ROD = (
    "duration = 1\n"
    "rods = [{radius = 1e-3, elements = 20, shape = {kind = 'straight', length = 0.1}, "
    "material = {E = 1e6, density = 1e3}}]\n"
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("preset = 'double_helix'\nr = -1e-4", "r = -0.0001: Input should be greater than 0"),
        ("preset = 'double_helix'\npitch1 = 18", "pitch1: unknown key"),
        ("preset = 'double_helix'\npi4 = 18", "pi4: unknown key; did you mean pi"),
        ("preset = 'double_helix'\nheight = 0.1\nturns = 3", "give height = 0.1 or turns = 3.0"),
        ("preset = 'double_helix'\nq = 40", "q = 40.0 pitches do not fit into a helix of 19.6"),
        ("preset = 'tripple'", "preset = 'tripple': choose from double_helix, curl"),
        ("preset = 'curl'\nn = 400\nspread = 1e-4", "has no room for 400 hairs"),
        ("duration = 1", "rods: missing"),
        ("rods = [", "not a TOML file"),
        ("preset = 'double_helix'\nheight = 0.15 m", "numbers stand without units"),
        ("preset = ['curl']", "preset = ['curl']: choose from double_helix, curl"),
        (ROD + "gravity = -9.81", "gravity = -9.81: three numbers in brackets"),
        (ROD + "damping = 3", "damping = 3: a table is needed here, [damping]"),
        (ROD + "[tines]\nradius = 1e-3", "tines: a list is needed here; if of tables, head each"),
        (ROD + "[damping]\ndrags = 3", "damping.drags: unknown key; did you mean drag?"),
        (ROD.replace("E =", "v = 0.4, E ="), "material.v: unknown key; known: E, nu, G, density,"),
        (ROD.replace("straight", "strait"), "rods.0.shape.kind = 'strait': choose from 'helix'"),
        (
            ROD.replace("'straight', length = 0.1", "'points', nodes = [[0, 0, 0], [0, 1]]"),
            "rods.0.shape.points.nodes.1: three numbers",
        ),
        (
            ROD.replace("length = 0.1", "lenght = 0.1"),
            "rods.0.shape.straight.length: missing",
        ),
    ],
)
def test_a_wrong_scene_is_refused_in_one_line_that_names_file_key_and_cure(
    tmp_path, text, expected
):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    with pytest.raises(sim.SceneError) as error:
        sim.load_scene(path)
    assert str(path) in str(error.value)
    assert expected in str(error.value)
    assert "\n" not in str(error.value)


def test_a_missing_scene_is_refused(tmp_path):
    with pytest.raises(sim.SceneError, match="no such file"):
        sim.load_scene(tmp_path / "none.toml")


def test_a_scene_written_out_reads_back_the_same():
    scene = sim.double_helix(pi1=24, friction=0.2, turns=3)
    assert Scene.model_validate_json(scene.model_dump_json()) == scene


def test_a_step_above_the_stability_limit_is_refused_with_the_limit():
    scene = sim.double_helix(turns=2).model_copy(update={"time_step": 1e-5})
    with pytest.raises(sim.SceneError, match="above the stability limit"):
        Explicit(scene)


def test_time_step_fits_the_sampling_window():
    scene = sim.double_helix(turns=2)
    march = explicit(scene)
    steps = 1 / scene.output.sample_rate / march.dt
    assert steps == pytest.approx(round(steps))
    assert march.dt <= scene.safety * march.limit * (1 + 1e-12)


def test_double_helix_touches_without_pressing_and_has_one_turn_per_pitch():
    scene = sim.double_helix(pi1=18, turns=6)
    a, b = build(scene).strands()
    r = scene.rods[0].radius
    middle = 0.5 * (a[1:] + a[:-1]), 0.5 * (b[1:] + b[:-1])
    gap = (
        np.linalg.norm(a - b, axis=1).mean()
        + 2 * np.linalg.norm(middle[0] - middle[1], axis=1).mean()
    )
    assert gap / 3 == pytest.approx(2 * r, rel=2e-3)  # Simpson: mean distance along the chords
    table = sim.link_density(a, b)
    assert table.attrs["total_link"] == pytest.approx(6, abs=1e-3)


def settling(elements_per_pitch):
    """Return how far, in radii, a double helix without tine moves away from where it was drawn."""
    scene = sim.double_helix(pi1=24, turns=3, elements_per_pitch=elements_per_pitch)
    march = explicit(scene.model_copy(update={"tines": []}))
    before = march.state.strands()
    march.advance(round(0.01 / march.dt))
    after = march.state.strands()
    return max(np.abs(a - b).max() for a, b in zip(before, after, strict=True)) / 4.25e-4


def test_the_resting_double_helix_rests_the_better_the_finer_its_mesh():
    """Straight chords of strands in contact overlap here and gape there, as the mesh squared."""
    coarse, fine = settling(12), settling(24)
    assert coarse < 0.15
    assert fine < 0.4 * coarse


def test_random_curvature_has_the_asked_spread_and_correlation_on_any_mesh(rng):
    for step in (2e-3, 1e-3):
        draw = random_curvature(np.full(200_000, step), 40.0, 0.01, rng=rng)[1:-1]
        a = step / 0.01  # means over a correlation lengths of exp(-|s|): a double integral
        spread = 40 * np.sqrt(2 * (a - 1 + np.exp(-a))) / a
        assert draw.std() == pytest.approx(spread, rel=0.02)
        lag = round(0.01 / step)
        found = np.mean(draw[lag:] * draw[:-lag]) / 40**2
        assert found == pytest.approx(np.exp(-1) * 2 * (np.cosh(a) - 1) / a**2, abs=0.02)
    per_node = random_curvature(np.full(100_001, 1e-3), 40.0, 0.0, rng=rng)[1:-1]
    assert per_node.std() == pytest.approx(40, rel=0.02)
    assert abs(np.mean(per_node[1:] * per_node[:-1])) / per_node.var() < 0.02


def drawn(lengths):
    return random_curvature(np.array(lengths), 40.0, 0.01, rng=np.random.default_rng(5))


def test_the_same_seed_is_the_same_hair_on_every_mesh():
    """What a node turns by is what all nodes of a finer mesh turn by that lie in its part."""
    coarse, fine = drawn([6e-3] * 20), drawn([2e-3] * 60)
    np.testing.assert_allclose(6e-3 * coarse[1:-1], 2e-3 * _triples(fine[2:-2]), rtol=1e-12)
    np.testing.assert_allclose(3e-3 * coarse[0], 1e-3 * fine[0] + 2e-3 * fine[1], rtol=1e-12)
    unlike = np.array([0.5e-3, 1e-3, 4e-3, 2e-3] * 16)
    parts = 0.5 * (np.append(unlike, 0) + np.insert(unlike, 0, 0))
    whole = 2e-3 * fine[1:-1].sum(axis=0) + 1e-3 * (fine[0] + fine[-1])
    np.testing.assert_allclose(parts @ drawn(unlike), whole, rtol=1e-12)


def _triples(values):
    return values.reshape(-1, 3, 2).sum(axis=1)


def test_a_longer_hair_is_the_same_as_far_as_the_shorter_goes():
    np.testing.assert_array_equal(drawn([1e-3] * 80)[:60], drawn([1e-3] * 100)[:60])


def test_curl_has_roots_apart_and_every_hair_its_own_curvature():
    state = build(sim.curl(n=12, seed=3))
    roots = np.array([strand[0] for strand in state.strands()])
    apart = np.linalg.norm(roots[:, None] - roots[None], axis=2) + np.eye(12)
    assert apart.min() > 2 * 7.5e-5
    curvature = state.rows("K0 K1")
    first, second = (curvature[:, state.nodes(rod)] for rod in (0, 1))
    assert abs(np.corrcoef(first[0], second[0])[0, 1]) < 0.9


def test_import_is_light():
    """`import sim` must not pay for numba, xarray or the kernels before they are used."""
    code = "import sim, sys; print([m for m in ('numba', 'xarray', 'pandas') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_a_value_that_is_not_a_number_is_refused(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        "duration = 1\n[[rods]]\nradius = nan\nelements = 4\n"
        "shape = {kind = 'straight', length = 1}\nmaterial = {E = 1e6, density = 1000}\n"
    )
    with pytest.raises(sim.SceneError, match=r"rods.0.radius = nan"):
        sim.load_scene(path)
