"""The axis of a double helix in space, from its course in the picture and its lean out of it."""

import numba
import numpy as np

from imaging.helix.model import Model
from imaging.helix.splines import curve

Array = np.ndarray
STEEPEST = 0.95  # sine of a lean; steeper, a strand is seen end on
STRIDE = 4.0  # px; between points of the axis whose writhe is summed
MOST = 800  # such points


def sine_of_lean(model: Model, s: Array) -> Array:
    """Sine of the angle by which the axis leaves the picture, tip away from the viewer > 0."""
    lean = curve(model.layout.lean, model.part("lean"), s)
    return np.clip(lean, -STEEPEST, STEEPEST)


def in_space(model: Model) -> tuple[Array, Array]:
    """Arclength in space and points (n, 3) of the axis at the model's table [px], z away."""
    table, sine = model.table, sine_of_lean(model, model.table.s)
    cosine = np.sqrt(1 - sine**2)
    arc = _integral(table.speed / cosine, table.s)
    depth = _integral(table.speed * sine / cosine, table.s)
    return arc, np.column_stack([table.axis, depth])


def heading(model: Model) -> Array:
    """Direction of the axis in the picture [rad], at the model's table."""
    x, y = model.table.tangents.T
    return np.unwrap(np.arctan2(y, x))


def link_beyond_phase(model: Model) -> Array:
    """Angle [rad] to add to the phase at the model's table, so that link is counted.

    Lk = Tw + Wr. The phase is counted from the picture's normal, which turns about an axis that
    leans and bends; twist is counted in the frame that does not. To it comes the writhe of the
    axis, each segment's share of the double integral (Klenin & Langowski, Biopolymers 54 (2000)).
    """
    s = model.table.s
    stride = int(max(STRIDE / (s[1] - s[0]), len(s) / MOST, 1))
    some = np.unique(np.r_[0 : len(s) : stride, len(s) - 1])
    turns = np.r_[0.0, np.cumsum(writhe_shares(in_space(model)[1][some]))]
    return _frame_turn(model) + 2 * np.pi * np.interp(s, s[some], turns)


def writhe_shares(points: Array) -> Array:
    """Writhe [turns] of each segment of a polyline (n, 3) with every other, by the midpoint rule.

    Axes are right-handed, as x right, y down, z away from the viewer are.
    """
    chord, middle = np.diff(points, axis=0), 0.5 * (points[1:] + points[:-1])
    shares = np.zeros(len(chord))
    _sum_writhe(chord, middle, shares)
    return shares / (4 * np.pi)


@numba.njit(cache=True, error_model="numpy")
def _sum_writhe(chord, middle, shares):
    """Add r (t x t') / |r|^3 of every two segments to both."""
    for i in range(len(chord)):
        a, b, c = chord[i, 0], chord[i, 1], chord[i, 2]
        for j in range(i):
            x, y = middle[i, 0] - middle[j, 0], middle[i, 1] - middle[j, 1]
            z = middle[i, 2] - middle[j, 2]
            d, e, f = chord[j, 0], chord[j, 1], chord[j, 2]
            cross = x * (b * f - c * e) + y * (c * d - a * f) + z * (a * e - b * d)
            part = cross / (x * x + y * y + z * z) ** 1.5
            shares[i] += part
            shares[j] += part


def _frame_turn(model: Model) -> Array:
    """Angle [rad] by which the picture's normal has turned about the axis.

    The sine of the lean times the change of heading, as the meridian turns along a circle of
    latitude.
    """
    course, sine = heading(model), sine_of_lean(model, model.table.s)
    steps = 0.5 * (sine[1:] + sine[:-1]) * np.diff(course)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _integral(values: Array, s: Array) -> Array:
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(s)
    return np.concatenate([[0.0], np.cumsum(steps)])
