"""What inserting the tines has done to a pair of strands before combing begins."""

from __future__ import annotations

import numpy as np

from sim.march.marching import Marching
from sim.topology import link_density

GONE = 0.5  # of the link as drawn: less is left when most of it is gone
BESIDE = 2.0  # times touching: a strand farther away is not what the tine combs


def link(march: Marching) -> float:
    """Return the link of a pair of strands as they are now."""
    return float(link_density(*march.state.strands()).attrs["total_link"])


def inserted(march: Marching, drawn: float) -> dict[str, float | str]:
    """Return what a run says of its insertion: the link that is left, and what went wrong.

    Parameters
    ----------
    march : Marching
        A pair of strands whose tines have just been inserted.
    drawn : float
        Their link before.
    """
    now = link(march)
    said: dict[str, float | str] = {"link_inserted": now}
    wrong = [
        f"tines.{m} is not between the strands once it is inserted: it has slipped out"
        for m, tine in enumerate(march.scene.tines)
        if tine.travel > 0 and not _parts_them(march, m)
    ]
    if abs(now) < GONE * abs(drawn):
        wrong.append(
            f"only {now:.2f} of {drawn:.2f} turns are left once the tines are inserted, before "
            "they move: insert more gently (a longer insertion, a larger damping.insertion)"
        )
    return said | ({"insertion": "; ".join(wrong)} if wrong else {})


def _parts_them(march: Marching, m: int) -> bool:
    """Tell whether both strands are beside a tine, one on either side of its way."""
    tine, radius = march.scene.tines[m], march.state.row("RADIUS")
    axis, way = (np.array(v) / np.linalg.norm(v) for v in (tine.axis, tine.direction))
    sides = []
    for rod, strand in enumerate(march.state.strands()):
        offset = strand - tine.position
        across = offset - np.outer(offset @ axis, axis)
        nearest = int(np.argmin(np.linalg.norm(across, axis=1)))
        touching = tine.radius + radius[march.state.first[rod]]
        if np.linalg.norm(across[nearest]) > BESIDE * touching:
            return False
        sides.append(float(offset[nearest] @ np.cross(axis, way)))
    return sides[0] * sides[1] < 0
