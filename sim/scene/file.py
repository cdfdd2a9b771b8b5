"""Scenes in TOML files: a preset by name with its parameters, or everything one by one."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from sim.errors import SceneError
from sim.scene import Scene
from sim.scene.complaints import first_complaint
from sim.scene.presets import preset_scene


def read_toml(path: str | Path) -> dict[str, Any]:
    """Read a TOML file; say in one line why if that cannot be done.

    Raises
    ------
    SceneError
        The file does not exist or is not TOML.
    """
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file; expected a scene in TOML") from None
    except OSError as error:
        raise SceneError(f"{path}: cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise SceneError(
            f"{path}: not a TOML file: {error}; numbers stand without units, text in quotes"
        ) from None


def load_scene(path: str | Path, *, seed: int | None = None, snapshots: int | None = None) -> Scene:
    """Read a scene from a TOML file: a preset by name with its parameters, or a whole scene.

    Parameters
    ----------
    path : path
        The file.
    seed, snapshots : int, optional
        Take these instead of what the file says.

    Raises
    ------
    SceneError
        The file is missing, is not TOML, or a key or value is wrong.
    """
    table = read_toml(path)
    preset = table.pop("preset", None)
    if seed is not None:
        table["seed"] = seed
    output = table if preset is not None else table.setdefault("output", {})
    if snapshots is not None and isinstance(output, dict):
        output["snapshots"] = snapshots
    try:
        return Scene(**table) if preset is None else preset_scene(preset, table)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None
    except ValidationError as error:
        raise SceneError(f"{path}: {first_complaint(error, Scene)}") from None
