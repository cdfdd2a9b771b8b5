"""The solver behind the interface of `cosseratbench`, held against that benchmark's references."""

from dataclasses import replace

import numpy as np
import pytest

cosseratbench = pytest.importorskip("cosseratbench", reason="the extra [referee]")

from cosseratbench import Motion, registry  # noqa: E402

from combing.referee import CombingSolver  # noqa: E402


def outcome(name, **options):
    experiment = registry.load_experiment(name)
    return cosseratbench.run(experiment, CombingSolver(), **options)


def test_the_benchmark_finds_the_solver_by_its_entry_point():
    assert isinstance(registry.load_solver("combing", time_step_scale=0.5), CombingSolver)


@pytest.mark.parametrize(
    ("name", "bounds"),
    [
        ("cantilever", {"tip_deflection_error": 3e-3, "settling_residual": 1e-5}),
        ("catenary", {"shape_error": 1e-3, "sag_error": 1e-3, "settling_residual": 1e-6}),
        ("pendulum", {"period_error": 5e-4, "amplitude_change": 1e-4}),
    ],
)
def test_experiments_end_near_their_references(name, bounds):
    result = outcome(name)
    assert result.outcome == "completed"
    for metric, bound in bounds.items():
        assert abs(result.metrics[metric]) < bound


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "bounds"),
    [
        ("twist", {"critical_twist_error": 0.01}),
        ("capstan", {"slide": 1e-4}),
        ("crossing", {"lift_error": 0.04}),
        ("pile", {"settling_residual": 0.01}),
    ],
)
def test_experiments_with_contact_and_courses_complete(name, bounds):
    result = outcome(name)
    assert result.outcome == "completed"
    for metric, bound in bounds.items():
        assert abs(result.metrics[metric]) < bound
    penetration = result.observations["max_penetration"]
    assert np.isnan(penetration) or penetration < 0.1


def test_a_clamp_follows_its_course_and_the_material_direction_turns_with_it():
    """A course with corners, given at uneven times; the director of the last element goes along."""
    scenario = registry.load_experiment("twist").scenario
    course = Motion(
        times=(0.0, 0.01, 0.04), displacement=((0, 0, 0),) * 3,
        rotation=((0, 0, 0), (0.3, 0, 0), (0.5, 0, 0)), slides_along=(1, 0, 0),
    )  # fmt: skip
    rope = replace(scenario.rods[0], end_motion=course)
    scenario = replace(scenario, rods=(rope,), duration=0.04, self_contact=False)
    shown = CombingSolver().run(scenario, n_elements=20, n_frames=5)
    assert shown.directors[0][0] == pytest.approx(rope.directors(20), abs=1e-9)
    assert shown.positions[0][-1, -1, 1:] == pytest.approx(rope.nodes(20)[-1, 1:], abs=1e-12)
    last = shown.directors[0][-1, -1]
    turned = np.arctan2(-last[1], last[2])
    assert 0.2 < turned < 0.55  # half an element behind a clamp turned by 0.5


def test_a_short_rope_follows_a_clamp_that_turns_about_one_axis_and_then_another():
    """Slowly: at the end all of it has turned as the clamp has, ends and material directions."""
    turns = ((0, 0, 0), (0, 0, 0.5), (0.4, 0, 0.5))  # rotation vectors: the axis changes
    course = Motion(times=(0.0, 0.5, 1.0), displacement=((0, 0, 0),) * 3, rotation=turns)
    rope = replace(
        registry.load_experiment("cantilever").scenario.rods[0], loads=(), start_motion=course,
        centerline=((0.0, 0.0, 0.0), (0.2, 0.0, 0.0)),
    )  # fmt: skip
    scenario = replace(registry.load_experiment("cantilever").scenario, rods=(rope,), duration=1.5)
    shown = CombingSolver().run(scenario, n_elements=8, n_frames=16)
    turned = course.pose(1.0)[1]
    assert shown.positions[0][-1] == pytest.approx(rope.nodes(8) @ turned.T, abs=2e-4)
    assert shown.directors[0][-1] == pytest.approx(rope.directors(8) @ turned.T, abs=2e-3)


def test_friction_that_differs_from_rod_to_rod_is_said_to_be_beyond_it():
    scenario = registry.load_experiment("crossing").scenario
    rods = (replace(scenario.rods[0], friction=0.3), scenario.rods[1])
    with pytest.raises(NotImplementedError, match="different coefficients"):
        CombingSolver().run(replace(scenario, rods=rods), n_elements=10, n_frames=2)
