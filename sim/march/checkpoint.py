"""All that changes in a march as named arrays, so that it can go on from there to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.march.marching import Marching

Arrays = dict[str, NDArray[Any]]
FORMAT = 3  # of what is saved: to be raised with every change of the lists below
ROWS = "X0 X1 X2 V0 V1 V2 Q00 Q01 Q02 Q10 Q11 Q12 Q20 Q21 Q22 W0 W1 W2 A0 A1 A2 G0 G1 G2 ROAM SWAY"
NUMBERS = ("steps", "ticks", "parts", "finest", "calm")
PAIRS = ("deep", "tight")
REPLACED = ("contact.pairs", "contact.listed")  # by every new list, never written to in place
RECORDS = {
    "contact": ("pairs", "slip", "listed", "runs", "play"),
    "planes": ("load", "slip"),
    "tines": ("now", "load", "work", "slip", "strands"),
    "driven": ("work", "reaction"),
    "held": ("net",),
    "pulled": ("work",),
    "ledger": ("drag", "material", "friction"),
}


def freeze(march: Marching) -> Arrays:
    """Return all that changes in a march, by name; views, good until it marches on."""
    # Row by row: what is written at once is copied twice on the way to the disk.
    frozen: Arrays = {name: march.state.row(name) for name in ROWS.split()}
    frozen |= {name: np.asarray(getattr(march, name)) for name in (*NUMBERS, *PAIRS)}
    frozen |= {f"{effect}.{name}": value for effect, name, value in _records(march)}
    return frozen | {"format": np.asarray(FORMAT)}


def mark(march: Marching) -> Arrays:
    """Return the same to fall back on: good while it marches on, with what is written to copied."""
    frozen = freeze(march)
    return {name: v if name in REPLACED else v.copy() for name, v in frozen.items()}


def thaw(march: Marching, frozen: Arrays) -> None:
    """Put what `freeze` returned into a march of the same scene.

    Raises
    ------
    ValueError
        It was written in another format, or a field is missing, unknown or of another size.
    """
    if int(frozen.get("format", -1)) != FORMAT:
        raise ValueError(f"format {frozen.get('format', 'unknown')}, this program reads {FORMAT}")
    _same_fields(freeze(march), frozen)
    for name in ROWS.split():
        march.state.row(name)[:] = frozen[name]
    for name in NUMBERS:
        setattr(march, name, int(frozen[name]))
    for name in PAIRS:
        setattr(march, name, frozen[name].copy())
    for effect, name, _ in list(_records(march)):
        value = getattr(march.effects, effect)._replace(**{name: frozen[f"{effect}.{name}"].copy()})
        march.effects = march.effects._replace(**{effect: value})


def _records(march: Marching) -> Iterator[tuple[str, str, NDArray[Any]]]:
    """Yield effect, name and array of all that effects record."""
    for effect, names in RECORDS.items():
        value = getattr(march.effects, effect)
        if value is not None:
            found = ((effect, name, getattr(value, name)) for name in names)
            yield from (each for each in found if each[2] is not None)


def _same_fields(here: Arrays, there: Arrays) -> None:
    if here.keys() != there.keys():
        raise ValueError(f"fields {', '.join(sorted(here.keys() ^ there.keys()))} do not belong")
    for name, value in there.items():
        grows = name in PAIRS or name.startswith("contact.")  # with the list of pairs
        same = value.ndim == here[name].ndim if grows else value.shape == here[name].shape
        if not same or value.dtype != here[name].dtype:
            raise ValueError(f"{name} has shape {value.shape} of {value.dtype}")
