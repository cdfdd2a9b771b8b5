"""Scenes at rest: the march, followed until Newton's method can finish it, or to its own end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from sim.errors import NotAtRest, SceneError
from sim.records.run import Run
from sim.scene import Scene
from sim.simulate import simulate
from sim.statics.settling import FINE


def equilibrium(
    scene: Scene,
    path: str | Path | None = None,
    *,
    tolerance: float = FINE,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Return the run of a scene that ends at rest.

    Rods that hang freely from clamps without touching are solved for at once, by Newton's method
    (`sim.statics`). Where strands touch, rest is not unique: the motion from the scene as drawn is
    followed until Newton's method can finish it. Other scenes are marched until they rest.

    Parameters
    ----------
    scene : Scene
        Its `duration` is the longest that is marched.
    path : path, optional
        As for `simulate`.
    tolerance : float
        Largest net force on a node, over its weight; over the largest inner force without gravity.
    progress : callable, optional
        As for `simulate`.

    Returns
    -------
    Run
        Its last snapshot is the state at rest; `attrs["rest"]` says how it was found.

    Raises
    ------
    SceneError
        The scene has friction, whose rest depends on the way there: simulate it `until = "rest"`.
    NotAtRest
        It has not come to rest within its duration. The error holds the run up to there.
    """
    if scene.friction is not None or any(plane.friction for plane in scene.planes):
        raise SceneError(
            "friction: where strands rest then depends on the way there; leave it out, or simulate "
            'the scene with until = "rest"'
        )
    asked = {"until": "rest", "rest_tolerance": tolerance}
    run = simulate(scene.model_copy(update=asked), path, progress=progress)
    if run.unrest():
        raise NotAtRest(run)
    return run
