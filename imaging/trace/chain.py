"""Chains: pieces of centrelines joined by bridges, each with its colour."""

from collections.abc import Container, Sequence
from typing import NamedTuple

import numpy as np

from imaging.trace.branches import End
from imaging.trace.matching import bridge


class Chain(NamedTuple):
    """Pieces joined: points (n, 2), their colours (n,), places (k, 2) of joins that are guesses."""

    line: np.ndarray
    tones: np.ndarray
    doubts: np.ndarray


def main_tone(tones: np.ndarray) -> int:
    """Return the colour that most of the points have."""
    return int(np.bincount(tones).argmax())


def connected(
    walk: list[tuple[int, bool]],
    pieces: Sequence[tuple[np.ndarray, int]],
    ends: Sequence[End],
    unsure: Container[tuple[int, int]],
) -> Chain:
    """Join pieces by bridges between them."""
    parts, tones, doubts = [], [], []
    for step, (branch, reverse) in enumerate(walk):
        path, colour = pieces[branch]
        if step:
            before, was_reverse = walk[step - 1]
            leave, entry = 2 * before + (not was_reverse), 2 * branch + reverse
            gap = bridge(ends[leave], ends[entry])[1:-1]
            parts.append(gap)
            tones.append(np.full(len(gap), colour))
            tones[-1][: len(gap) // 2] = pieces[before][1]
            if (min(leave, entry), max(leave, entry)) in unsure:
                doubts.append((ends[leave].point + ends[entry].point) / 2)
        parts.append(path[::-1] if reverse else path)
        tones.append(np.full(len(path), colour))
    return Chain(np.concatenate(parts), np.concatenate(tones), np.reshape(doubts, (-1, 2)))
