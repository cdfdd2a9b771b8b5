"""Strands before a ground with texture: ridges that stand out from it, and then their colours.

Ridges (`ridges`) are cut into pieces along their crests (`crests`); seams of tiles and the like are
taken out (`lattice`), and shadows (`cast`); what covers pixels is told from the ground beside the
pieces; colours are named after the pieces that have them (`naming`). `imaging.trace` joins them.
"""

from collections.abc import Sequence

import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment.cast import grounds, of_ground, of_shadow
from imaging.segment.coverage import EDGE, coverage_of, shared_out
from imaging.segment.crests import BROAD, Piece, near_pieces, pieces_of, sure_ones, usual_width
from imaging.segment.depths import depth_of
from imaging.segment.ground import Ground, contrast_of, ground_between, in_even_light
from imaging.segment.lattice import of_lattice
from imaging.segment.naming import named, of_enough, painted
from imaging.segment.ridges import find_ridges
from imaging.segment.segmentation import Segmentation

NOTHING = (
    "nothing stands out from the background's texture; photograph the strands on a plain surface"
)
ENOUGH = 8.0  # strand widths of a colour, all its pieces together; less is no strand
LEAST, MOST = 0.8, 1.8  # times the width at which ridges stand out well; strands are as wide


def by_ridge(
    photo: Photo, lab: np.ndarray, ground: Ground, ruling: np.ndarray | None
) -> Segmentation:
    """Separate strands from a ground with texture, and from each other.

    Parameters
    ----------
    photo : Photo
    lab : (h, w, 3) array
        Taken over: turned into colours in even light.
    ground : Ground
    ruling : (h, w) bool array or None
        Lines of a grid that were erased.

    Raises
    ------
    Unmeasurable
        When nothing stands out from the ground.
    """
    pieces = pieces_of(find_ridges(lab, photo.ignore), lab)
    if pieces:
        pieces, _ = named(pieces)
        seam = of_lattice(pieces, lab.shape[:2])
        pieces = [piece for piece, one in zip(pieces, seam, strict=True) if not one]
    if pieces:
        width = usual_width(pieces)
        pieces = [piece for piece in pieces if piece.width < BROAD * width]
        pieces = of_enough(pieces, ENOUGH * width)
    shadow = None
    if pieces:
        pieces, shadow = _without_shadows(pieces, lab, ground)
    if not pieces:
        raise Unmeasurable(f"{photo.source}: {NOTHING}")
    pieces, colours = named(pieces)
    near = near_pieces(pieces, lab.shape[:2])
    if shadow is not None:
        near &= ~shadow
    ground = ground_between(lab, near, usual_width(pieces), ground)
    coverage, _ = coverage_of(photo, contrast_of(lab, ground), near)
    width = _seen_width(pieces, coverage > EDGE)
    labels = painted(pieces, coverage > EDGE, lab, width)
    membership = shared_out(coverage, labels, len(colours))
    contrast, nothing = in_even_light(lab, ground), np.zeros(labels.shape, bool)
    return Segmentation(
        labels, membership, colours, width, contrast, nothing, coverage, ruling, shadow, pieces
    )


def _without_shadows(
    pieces: list[Piece], lab: np.ndarray, ground: Ground
) -> tuple[list[Piece], np.ndarray | None]:
    """Pieces that are neither shadow nor ground, and where shadows lie (h, w)."""
    width = usual_width(pieces)
    under = grounds(
        pieces, ground_between(lab, near_pieces(pieces, lab.shape[:2]), width, ground), lab.shape[1]
    )
    shadow = of_shadow(pieces, under, lab, width)
    none = shadow | of_ground(pieces, under)
    cast = [piece for piece, own in zip(pieces, shadow, strict=True) if own]
    left = [piece for piece, own in zip(pieces, none, strict=True) if not own]
    return left, near_pieces(cast, lab.shape[:2]) if cast else None


def _seen_width(pieces: Sequence[Piece], strand: np.ndarray) -> float:
    """Width of the strands [px]: that of what is covered around sure pieces."""
    depth, width = depth_of(strand), usual_width(pieces)
    x, y = np.rint(np.concatenate([p.line for p in sure_ones(pieces)])).astype(int).T
    deep = depth[y, x]
    seen = 2 * float(np.median(deep[deep > 0])) - 1 if (deep > 0).any() else width
    return float(np.clip(seen, LEAST * width, MOST * width))
