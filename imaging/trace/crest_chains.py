"""Pieces of ridges joined into chains: one matching over bending, gap and distance of colours."""

from collections.abc import Sequence

import numpy as np

from imaging.segment.crests import Piece, stands_out
from imaging.trace.branches import ends_of
from imaging.trace.centreline import arclength, smoothed
from imaging.trace.chain import Chain, connected, main_tone
from imaging.trace.matching import Gain, chains, doubtful, join, refund, within_colour

SOFT = 8.0  # Lab units; sd of the mean colour of one strand from piece to piece, by light and gloss
MOST = 25.0  # cost of any difference of colour; parts of one strand may be in shade
TAIL = 2.0  # strand widths, at most, by which a ridge is seen beyond a strand's end
SHORTEST = 6.0  # strand widths; a shorter chain is a speck


def ridge_chains(found: Sequence[Piece], covered: np.ndarray, width: float) -> list[Chain]:
    """Join pieces of ridges and keep the chains that stand out from the ground's texture.

    Parameters
    ----------
    found : sequence of Piece
    covered : (h, w) bool array
        Where a strand may hide: under any strand.
    width : float
        Strand width [px].
    """
    crests = [piece for piece in found if len(piece.line) > width]
    pieces = [(_smooth(piece.line, width), piece.tone) for piece in crests]
    ends = ends_of([line for line, _ in pieces], width)
    gains = within_colour(ends, covered, np.zeros_like(covered), width)
    gains = _less_for_colour(gains, crests)
    refunds = [refund(float(arclength(line)[-1]), False, width) for line, _ in pieces]
    joins = join(ends, refunds, gains)
    unsure = doubtful(joins, gains)
    kept = []
    for walk in chains(len(pieces), joins):
        chain = connected(walk, pieces, ends, unsure)
        if _is_strand(chain, [crests[branch] for branch, _ in walk], width):
            tone = main_tone(chain.tones)
            line = _trimmed(chain.line, covered, width)
            kept.append(Chain(line, np.full(len(line), tone), chain.doubts))
    return sorted(kept, key=lambda chain: (chain.tones[0], -len(chain.line)))


def _smooth(line: np.ndarray, width: float) -> np.ndarray:
    """Crest without the steps from pixel to pixel."""
    return smoothed(line, np.ones(len(line)), width)


def _less_for_colour(gains: Sequence[Gain], pieces: Sequence[Piece]) -> list[Gain]:
    """Take from each gain the squared distance of the two colours over its variance.

    The mean colour of a striped piece is known the worse the shorter it is: its variance is that
    of single pixels over the widths that it is long.
    """
    colour = np.array([piece.colour for piece in pieces])
    vague = np.array([(p.spread**2).sum() * p.width / len(p.line) for p in pieces])
    left = []
    for i, j, gain in gains:
        a, b = i // 2, j // 2
        off = ((colour[a] - colour[b]) ** 2).sum() / (SOFT**2 + vague[a] + vague[b])
        left.append((i, j, gain - min(float(off), MOST)))
    return [one for one in left if one[2] > 0]


def _trimmed(line: np.ndarray, covered: np.ndarray, width: float) -> np.ndarray:
    """Line without what of its ends lies in the open: a ridge is seen a little beyond its end."""
    x, y = np.rint(line).astype(int).T
    last_y, last_x = np.subtract(covered.shape, 1)
    shown = np.flatnonzero(covered[y.clip(0, last_y), x.clip(0, last_x)])
    if len(shown) == 0:
        return line
    most = int(TAIL * width)
    return line[min(shown[0], most) : max(shown[-1] + 1, len(line) - most)]


def _is_strand(chain: Chain, pieces: Sequence[Piece], width: float) -> bool:
    length = float(arclength(chain.line)[-1])
    along = np.repeat([p.response for p in pieces], [len(p.line) for p in pieces])
    return length > SHORTEST * width and stands_out(float(np.median(along)), length, width)
