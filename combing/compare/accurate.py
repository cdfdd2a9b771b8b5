"""Scenes of a study held to its tolerance: settings chosen, verified, and said."""

from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any

import sim
from combing.compare.jobs import label
from combing.errors import UserError
from combing.tolerance import in_words, often, settle
from combing.tolerance.setting import Setting, with_setting

Scenes = dict[Hashable, sim.Scene]


def held_to(
    scenes: Scenes, alike: Mapping[Hashable, Hashable], folder: Path, tolerance: float, **how: Any
) -> tuple[Scenes, list[str]]:
    """Return scenes with settings that hold a tolerance, and what is said of each.

    Of scenes that are alike, an ensemble's members, the first is verified and the others take its
    setting. What does not move a tine, or cannot be held to a tolerance, stays as it is.

    Parameters
    ----------
    scenes : dict
        By the keys of `Job.scenes`.
    alike : mapping
        What scenes of one ensemble have in common, by key.
    folder : Path
        Where runs are kept.
    tolerance : float
    how
        jobs, quiet: as of `combing.runs.simulating`.
    """
    found: dict[Hashable, Setting | None] = {}
    held, notes = dict(scenes), []
    for key, scene in scenes.items():
        if not any(tine.travel > 0 for tine in scene.tines):
            continue
        group = alike.get(key, key)
        if group not in found:
            found[group], said = _settled(scene, folder, tolerance, **how)
            notes.append(f"{label(key)}: {said}")
        setting = found[group]
        if setting is not None:
            held[key] = with_setting(often(scene), setting)
    return held, notes


def _settled(
    scene: sim.Scene, folder: Path, tolerance: float, **how: Any
) -> tuple[Setting | None, str]:
    try:
        _, record = settle(scene, folder, tolerance, **how)
    except (UserError, sim.SceneError, sim.Unstable) as error:
        return None, f"no setting was chosen, it is simulated as it is: {error}"
    words = [f"{key}: {value}" for key, value in in_words(record).items()]
    return Setting(**record["setting"]), "; ".join(words)
