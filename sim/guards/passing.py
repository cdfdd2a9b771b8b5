"""Where a march lets strands pass through each other: a contact that has all but given way."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from sim.errors import Unstable
from sim.kernels import passing as kernels
from sim.march.marching import Marching, Pairs, no_pairs
from sim.march.timestep import BENDING, SPRING

DEEP = 0.5  # of the contact distance
ROOM = 16  # pairs at first; a contact that gives way is one of a few
NEXT_TO = 2  # elements: as far as an overlap slides along a strand between two looks


def deep_pairs(march: Marching, limit: float = DEEP) -> Pairs:
    """Return the pairs of elements nearer than this part of the contact distance, (m, 2)."""
    if march.contact is None:
        return no_pairs()
    return _all_of(kernels.near_pairs, march, limit)


def tight_bends(march: Marching) -> Pairs:
    """Return the pairs of elements between which a rod is bent through itself, (m, 2).

    Only where rods may touch themselves.
    """
    contact = march.contact
    if contact is None or math.isinf(contact.self_gap):
        return no_pairs()
    return _all_of(kernels.tight_bends, march, DEEP)


def _all_of(find: Callable[..., int], march: Marching, limit: float) -> Pairs:
    """Return all pairs that a kernel finds, making room when there are more than expected."""
    room = ROOM
    while True:
        found = np.zeros((room, 2), np.int64)
        count = find(march.state.buf, march.state.n, march.contact, limit, found)
        if count <= room:
            return found[:count]
        room = count


def nearness(march: Marching, a: int, b: int) -> float:
    """Return the distance of elements a and b over that of touching."""
    return math.sqrt(kernels.nearness(march.state.buf, a, b, march.contact))


def newcomer(now: Pairs, before: Pairs) -> tuple[int, int] | None:
    """Return a pair that was not among those before, nor next to one, if there is any.

    Strands may start in each other, and are pushed apart; what counts is what the march does.
    """
    for a, b in now.tolist():
        if not (np.abs(before - (a, b)).max(axis=1) <= NEXT_TO).any():
            return a, b
    return None


def passing_through(march: Marching, a: int, b: int) -> Unstable:
    """Return the error that says which two elements are on their way through each other."""
    state, contact = march.state, march.contact
    assert contact is not None
    x, radius = state.rows("X0 X1 X2").T, state.row("RADIUS")
    dp, u = x[a + 1] - x[a], x[b + 1] - x[b]
    sine = np.linalg.norm(np.cross(dp, u)) / (np.linalg.norm(dp) * np.linalg.norm(u))
    reach = radius[a] + radius[b]
    longest = float(max(state.row("LENGTH")[[a, b]]))
    load = kernels.load_around(state.buf, state.n, contact, a, b, longest)
    near = nearness(march, a, b)
    # The most that k (reach - d), integrated along a straight line, gives over all distances.
    most = 0.552 * contact.stiffness * reach**2 / max(sine, 1e-3)
    (rod, element), (other, there) = state.place(a), state.place(b)
    return Unstable(
        f"strands pass through each other at t = {march.time:.6g} s: element {element} of rod "
        f"{rod} and element {there} of rod {other} are {near:.2f} of the contact distance apart, "
        f"pressed with {load:.3g} N; at this angle a crossing bears at most {most:.3g} N; "
        f"increase contact.stiffness from {contact.stiffness:.3g} N/m^2, or load less",
        march.time, rod, element, "contact of rods", SPRING, (other, there),
    )  # fmt: skip


def bent_through(march: Marching, a: int, b: int) -> Unstable:
    """Return the error that says where a rod is bent so tightly that it passes through itself."""
    state, contact = march.state, march.contact
    assert contact is not None
    near = kernels.tightness(state.buf, a, b, contact)
    (rod, element), (_, there) = state.place(a), state.place(b)
    return Unstable(
        f"a strand passes through itself at t = {march.time:.6g} s: rod {rod} is bent more tightly "
        f"than round its own radius between elements {element} and {there}, which are {near:.2f} "
        "of the least distance apart; turns would be lost unseen; twist it less, or pull it less "
        "while it is twisted",
        march.time, rod, element, "elasticity", BENDING, (rod, there),
    )  # fmt: skip
