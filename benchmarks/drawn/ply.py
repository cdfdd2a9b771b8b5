"""Drawn photographs of a pair folded and plied back on itself: four strands, two by two."""

import numpy as np

from drawn.helix import BLUE, RED, Light, bent_axis, draw_tubes, framed, twist_in_space

Array = np.ndarray


def draw_ply(r: float, rng: np.random.Generator, *, sign: int = 1, **look) -> np.ndarray:
    """Draw four strands of radius ``r`` [px], two by two, of two colours.

    Each pair winds one way (``sign``), the two pairs about each other the other way, as a twisted
    pair does that is folded in the middle and let go.
    """
    own, back = r * rng.uniform(11, 17), r * rng.uniform(16, 30)
    s = np.arange(0.0, rng.uniform(3, 5) * back, 0.5)
    bend = rng.uniform(-0.6, 0.6)
    axis = np.column_stack([bent_axis(s, bend * np.sin(np.pi * s / s[-1])), 0 * s])
    pairs = twist_in_space(axis, -sign * 2 * np.pi * s / back + rng.uniform(0, 6), 1.7 * r)
    strands = []
    for middle in pairs:
        strands += twist_in_space(middle, sign * 2 * np.pi * s / own + rng.uniform(0, 6), r)
    seen, shape, _ = framed(strands, 16.0 * r)
    options = {"background": (235, 235, 230), "blur": 1.0, "noise": 0.02, "light": Light()}
    colours = look.pop("colours", (RED, BLUE))
    return draw_tubes(seen, r, shape, colours=(*colours, *colours), rng=rng, **(options | look))[0]
