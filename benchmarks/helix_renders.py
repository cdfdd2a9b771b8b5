"""Varied photographs of twisted strands, drawn with their truth: hanging pairs, and combed ones.

A hanging pair is even, or its link density steps or waves. A combed one hangs apart down to a tine,
kinks there, is over-wound and wound in space ahead of it, and is seen in perspective.
"""

import numpy as np
import pandas as pd
from drawn.helix import (
    Light,
    SyntheticHelix,
    draw_helix,
    draw_tubes,
    framed,
    twist_in_space,
)

import sim
from sim.topology import common_arclength, partners

Array = np.ndarray
SHAPES = ("even", "step", "wave", "combed")
COLOURS = (
    ((200, 40, 40), (40, 70, 190)),
    ((30, 110, 60), (220, 170, 30)),
    ((150, 60, 150), (60, 160, 90)),
)
BLACK_AND_RED = ((25, 25, 28), (200, 50, 40))
TINE = (90, 92, 95)
NODES = 900  # of each strand whose link is summed


def varied(seed: int) -> SyntheticHelix:
    """Draw a photograph with everything varied: size, twist, hand, bend, light, cloth, blur, noise.

    A quarter each are even, step or wave in their link density, and combed; half of all lie before
    a dark cloth.
    """
    rng = np.random.default_rng(seed)
    r = rng.uniform(4, 7.5)
    look = _look(rng, dark=is_dark(seed))
    shape = SHAPES[seed % len(SHAPES)]
    return combed(r, rng, look) if shape == "combed" else hanging(r, shape, rng, look)


def is_dark(seed: int) -> bool:
    """Whether the photograph lies before a dark cloth."""
    return bool((seed // len(SHAPES)) % 2)


def _look(rng: np.random.Generator, *, dark: bool) -> dict:
    """Colours, light and camera."""
    choice = COLOURS if dark else (*COLOURS, BLACK_AND_RED)
    lamp = (rng.uniform(-0.6, 0.6), rng.uniform(-0.5, 0.2), 0.8)
    return {
        "colours": choice[rng.integers(len(choice))],
        "background": tuple(rng.integers(15, 60, 3) if dark else rng.integers(215, 245, 3)),
        "blur": rng.uniform(0.7, 1.5),
        "noise": rng.uniform(0.01, 0.03),
        "light": Light(
            direction=lamp,
            ambient=rng.uniform(0.2, 0.5),
            highlight=rng.uniform(0, 0.4),
            uneven=rng.uniform(0, 0.4),
        ),
        "rng": rng,
    }


def hanging(r: float, shape: str, rng: np.random.Generator, look: dict) -> SyntheticHelix:
    """Draw a pair that hangs in a bow, leans a little, and may be wider than its strands."""
    pitch = r * rng.uniform(16, 28)
    length = rng.uniform(4, 5.5) * pitch
    depth = rng.uniform(0.02, 0.2)
    place, wave = rng.uniform(0.3, 0.7) * length, rng.uniform(3, 8) * pitch
    sign = rng.choice([-1, 1])
    bend = rng.uniform(-0.6, 0.6)

    def link(s: Array) -> Array:
        change = {"even": 0 * s, "wave": np.sin(2 * np.pi * s / wave), "step": np.sign(s - place)}
        return sign / pitch * (1 + depth * change[shape])

    return draw_helix(
        r, link, length,
        helix_radius=r * rng.choice([1.0, rng.uniform(1.0, 1.6)]),
        heading=lambda s: bend * np.sin(np.pi * s / length),
        phase=rng.uniform(0, 2 * np.pi),
        tilt=np.radians(rng.uniform(-5, 5)),
        **look,
    )  # fmt: skip


def combed(r: float, rng: np.random.Generator, look: dict) -> SyntheticHelix:
    """Draw a pair with a tine in it.

    Ahead of the tine: over-wound by up to half, which fades over a pitch and a half; a kink of up
    to 75 degrees, from which it bends back towards the vertical; its axis winds in space by up to
    20 degrees and hangs up to 8 degrees out of the picture. Half of all tines are seen.
    """
    pitch = r * rng.uniform(17, 24)
    s = np.arange(0.0, rng.uniform(8, 10) * pitch, 0.25)
    x = s - rng.uniform(2, 3.5) * pitch
    phi = rng.choice([-1, 1]) * _combed_phase(x / pitch, rng)
    radius = r * np.where(x < 0, rng.uniform(1.5, 2.5), 1.0)
    thick = rng.uniform(1.5, 2.5)
    radius = _eased(radius, pitch / 6) + thick * r * np.exp(-((x / (0.3 * pitch)) ** 2))
    axis = _combed_axis(s, x / pitch, rng)
    strands = twist_in_space(axis, phi, radius)
    distance = rng.uniform(5, 12) * float(np.ptp(axis[:, :2], axis=0).max())
    truth = _truth(axis, strands, distance)
    seen, shape, shift = framed([_projected(p, axis, distance) for p in strands], 16.0 * r)
    truth[["x", "y"]] += shift
    at = float(np.interp(0.0, x, _projected(axis, axis, distance)[:, 1] + shift[1]))
    shown = rng.random() < 0.5
    colours = (*look.pop("colours"), TINE)
    pixels, membership = draw_tubes(
        seen, r, shape, colours=colours, tine=(at, thick * r) if shown else None, **look
    )
    return SyntheticHelix(pixels, membership, seen, truth, r)


def _combed_phase(x: Array, rng: np.random.Generator) -> Array:
    """Phase at x pitches from the tine, where the strands lie side by side."""
    over, behind = rng.uniform(0, 0.5), rng.uniform(0, 0.3)
    wound = np.where(x < 0, behind, 1 + over * np.exp(-np.maximum(x, 0) / 1.5))
    density = wound * (1 - np.exp(-((x / 0.25) ** 4)))
    turns = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(x))])
    return 2 * np.pi * (turns - np.interp(0.0, x, turns))


def _combed_axis(s: Array, x: Array, rng: np.random.Generator) -> Array:
    """Axis in space (n, 3), x right, y down, z to the viewer, at x pitches from the tine."""
    kink, back = np.radians(rng.uniform(-75, 75)), rng.uniform(2, 6)
    wound, period = np.radians(rng.uniform(0, 20)), rng.uniform(0.9, 1.5)
    leaning, swing = np.radians(rng.uniform(-8, 8, 2))
    angle = 2 * np.pi * x / period + rng.uniform(0, 2 * np.pi)
    ahead = 1 / (1 + np.exp(-x / 0.08))
    fades = ahead * wound * np.exp(-np.maximum(x, 0) / 1.2)
    heading = ahead * kink * np.exp(-np.maximum(x, 0) / back) + fades * np.sin(angle)
    lean = ahead * (leaning + swing * np.sin(np.pi * x / x[-1])) + fades * np.cos(angle)
    tangent = np.column_stack(
        [np.sin(heading) * np.cos(lean), np.cos(heading) * np.cos(lean), -np.sin(lean)]
    )
    steps = 0.5 * (tangent[1:] + tangent[:-1]) * np.diff(s)[:, None]
    return np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])


def _eased(values: Array, length: float) -> Array:
    """Smooth values at every quarter of a pixel over ``length`` [px]."""
    size = int(4 * length)
    kernel = np.hanning(2 * size + 1)
    padded = np.pad(values, size, mode="edge")
    return np.convolve(padded, kernel / kernel.sum(), mode="valid")


def _projected(points: Array, axis: Array, distance: float) -> Array:
    """Points as a pinhole camera ``distance`` [px] before the middle of an axis sees them."""
    centre = np.append(0.5 * (axis[:, :2].min(axis=0) + axis[:, :2].max(axis=0)), 0.0)
    scale = distance / (distance - points[:, 2:])
    return centre + (points - centre) * np.hstack([scale, scale, np.ones_like(scale)])


def _truth(axis: Array, strands: list[Array], distance: float) -> pd.DataFrame:
    """Link density of strands in space, as topology has it, where the picture shows it.

    Per pixel at the pair's own distance from the camera, which a picture does not tell.
    """
    stride = max(len(axis) // NODES, 1)
    a, b = (p[::stride] * [1, 1, -1] for p in strands)
    table = sim.link_density(a, b)
    turns = abs(table.attrs["total_link"])
    place = partners(a, b, turns)
    index = np.arange(len(b))
    middle = 0.5 * (a + np.column_stack([np.interp(place, index, b[:, k]) for k in range(3)]))
    middle[:, 2] *= -1
    s = common_arclength(a, b, turns)[0]
    link = np.interp(s, table["s"], table["link"]) * (1 - middle[:, 2] / distance)
    seen = _projected(middle, axis, distance)
    phi = 2 * np.pi * np.concatenate([[0], np.cumsum(np.diff(s) * 0.5 * (link[1:] + link[:-1]))])
    return pd.DataFrame({"s": s, "phi": phi, "link": link, "x": seen[:, 0], "y": seen[:, 1]})
