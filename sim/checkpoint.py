"""Everything a march holds as named arrays, so that it can go on later to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.kernels import layout
from sim.marching import Marching

Arrays = dict[str, NDArray[Any]]
RECIPE = {"scene", "state"}  # the scene makes a march; of the state only the buffer changes


def freeze(march: Marching) -> Arrays:
    """Return all that a march holds, by name; views, good until it marches on.

    Raises
    ------
    TypeError
        The march holds something that is neither a number, an array nor a tuple of such, which
        would be lost.
    """
    # Row by row: what is written at once is copied twice on the way to the disk.
    frozen: Arrays = dict(zip(layout.ROW, march.state.used(), strict=True))
    for name, value in vars(march).items():
        if name not in RECIPE:
            _pack(name, value, frozen)
    return frozen


def thaw(march: Marching, frozen: Arrays) -> None:
    """Put what `freeze` returned into a march of the same scene."""
    for name, row in zip(layout.ROW, march.state.used(), strict=True):
        row[:] = frozen[name]
    for name, value in vars(march).items():
        if name not in RECIPE:
            setattr(march, name, _unpack(name, value, frozen))


def _fields(name: str, value: Any) -> dict[str, Any]:
    """Return the fields of a NamedTuple by their full names."""
    return {f"{name}.{field}": getattr(value, field) for field in value._fields}


def _pack(name: str, value: Any, frozen: Arrays) -> None:
    if isinstance(value, tuple):
        for field, part in _fields(name, value).items():
            _pack(field, part, frozen)
    elif isinstance(value, np.ndarray | np.number | float | int):
        frozen[name] = np.asarray(value)
    elif value is not None:
        raise TypeError(f"{name}: a checkpoint cannot hold a {type(value).__name__}")


def _unpack(name: str, value: Any, frozen: Arrays) -> Any:
    """Return what was frozen, of the type of `value`: the compiled march knows it by its types."""
    if value is None:
        return None
    if isinstance(value, tuple):
        parts = (_unpack(*each, frozen) for each in _fields(name, value).items())
        return type(value)(*parts)
    if isinstance(value, np.ndarray):
        return frozen[name].copy()
    return type(value)(frozen[name].item())
