"""What must hold in every hard case, and the pieces their scenes are made of."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sim.energy import elastic_energy, kinetic_energy, weight_energy
from sim.explicit import Explicit
from sim.kernels.ledger import tine_energy
from sim.scene import Contact, Damping, End, Material, Points, Rod, Scene

SOFT = Material(E=1e6, nu=0.5, density=1000)
FREE, PINNED, CLAMPED = End(), End(hold="pinned"), End(hold="clamped")
SEPARATE = 0.5  # of the contact distance: closer than that, strands are on their way through


def line(middle, direction, length, elements):
    """Return the nodes of a straight strand about its middle, (elements + 1, 3)."""
    unit = np.asarray(direction, float) / np.linalg.norm(direction)
    return np.asarray(middle, float) + np.linspace(-0.5, 0.5, elements + 1)[:, None] * length * unit


def rod(nodes, radius, material=SOFT, *, root=FREE, tip=FREE, rest="drawn"):
    """Return a strand through the given nodes."""
    shape = Points(nodes=[tuple(map(float, p)) for p in nodes])
    return Rod(shape=shape, radius=radius, elements=2, material=material, root=root, tip=tip,
               rest=rest)  # fmt: skip


def march_of(*rods, drag=1e-9, viscous=1e-12, gravity=(0, 0, 0), contact=None, **others):
    """Return the march of a scene that names gravity, damping and contact even where they are nil.

    All hard cases then share a few compiled marches instead of having one each. A single strand
    touches nothing unless told; its contact stiffness is too small to shorten the step.
    """
    if contact is None:
        contact = Contact() if len(rods) > 1 else Contact(stiffness=1.0)
    return Explicit(
        Scene(
            rods=list(rods), duration=1, gravity=gravity, contact=contact,
            damping=Damping(drag=drag, material=viscous), **others,
        )
    )  # fmt: skip


def segment_distances(p, q):
    """Return the distances of all segments of polyline p to all of q, (n, m)."""
    return between(p[:-1, None], p[1:, None], q[None, :-1], q[None, 1:])


def between(p0, p1, q0, q1):
    """Return the distances of segments from p0 to p1 to segments from q0 to q1."""
    ends = np.min(
        [
            _to_segment(p0, q0, q1), _to_segment(p1, q0, q1),
            _to_segment(q0, p0, p1), _to_segment(q1, p0, p1),
        ],
        axis=0,
    )  # fmt: skip
    u, v, w = p1 - p0, q1 - q0, p0 - q0
    a, b, c = _dot(u, u), _dot(u, v), _dot(v, v)
    d, e = _dot(u, w), _dot(v, w)
    det = a * c - b * b
    crossing = det > 1e-12 * a * c
    det = np.where(crossing, det, 1.0)
    s, t = (b * e - c * d) / det, (a * e - b * d) / det
    crossing &= (s > 0) & (s < 1) & (t > 0) & (t < 1)
    across = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
    return np.where(crossing, np.minimum(across, ends), ends)


def _dot(a, b):
    return np.sum(a * b, axis=-1)


def _to_segment(x, a, b):
    u = b - a
    t = np.clip(_dot(x - a, u) / _dot(u, u), 0, 1)
    return np.linalg.norm(x - a - t[..., None] * u, axis=-1)


def closest(march):
    """Return the smallest distance of two strands, or of two parts of one, over that of contact.

    Parts of one strand count when they are further apart along it than contact can bend it;
    infinite when nothing is near.
    """
    state, rods = march.state, march.state.rod_of_element()
    x, radius, length = state.rows("X0 X1 X2").T, state.row("RADIUS"), state.row("LENGTH")
    i = np.flatnonzero(rods >= 0)
    middle = 0.5 * (x[i] + x[i + 1])
    near = 3 * radius.max() + 2 * length.max()
    a, b = i[cKDTree(middle).query_pairs(near, output_type="ndarray").reshape(-1, 2)].T
    arc = np.cumsum(length) - length
    gap = 2 * math.pi * radius.max() if march.scene.contact.self_contact else np.inf
    apart = (rods[a] != rods[b]) | (abs(arc[b] - arc[a]) - np.minimum(length[a], length[b]) > gap)
    a, b = a[apart], b[apart]
    gaps = between(x[a], x[a + 1], x[b], x[b + 1]) / (radius[a] + radius[b])
    return gaps.min(initial=np.inf)


def energies(march):
    """Return kinetic, elastic and contact energy, that of weight, and less the work put in [J]."""
    state, effects = march.state, march.effects
    weight = weight_energy(state, march.scene.gravity or (0, 0, 0))
    contact = contact_potential(march)
    if effects.tines:
        contact += tine_energy(state.buf, state.n, effects.tines)
    work = [each.work[0] for each in (effects.tines, effects.driven, effects.pulled) if each]
    return np.array([kinetic_energy(state), elastic_energy(state), contact, weight, -sum(work)])


def contact_potential(march, samples=64):
    """Return U = sum of integrals k/2 (reach - d)_+^2 ds over the pairs in contact [J].

    Written with sums over many samples, apart from the kernels' clipped Gauss points.
    """
    contact, state = march.contact, march.state
    if contact is None or contact.pairs.size == 0:
        return 0.0
    a, b = contact.pairs
    x, radius = state.rows("X0 X1 X2").T, state.row("RADIUS")
    s = (np.arange(samples) + 0.5)[:, None, None] / samples
    points = x[a] + s * (x[a + 1] - x[a])
    u = x[b + 1] - x[b]
    t = np.clip(_dot(points - x[b], u) / _dot(u, u), 0, 1)
    gap = np.linalg.norm(points - x[b] - t[..., None] * u, axis=-1)
    deep = np.maximum(radius[a] + radius[b] - gap, 0) * _owned(state, points, b)
    return float(0.5 * contact.stiffness * (deep**2).mean(axis=0) @ state.row("LENGTH")[a])


def _owned(state, points, b):
    """Tell which points lie between the planes that bisect the corners at b's ends."""
    x, overhang = state.rows("X0 X1 X2").T, state.row("OVERHANG")
    tangent = np.diff(x, axis=0, append=x[-1:])
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
    normal = state.row("PREVIOUS")[:, None] * np.roll(tangent, 1, axis=0)
    normal += state.row("NEXT")[:, None] * tangent
    after = _dot(points - x[b], normal[b]) + overhang[b] >= 0
    before = _dot(points - x[b + 1], normal[b + 1]) - overhang[b + 1] <= 0
    return after & before


@dataclass
class Watch:
    """What was seen: closest approach over contact distance, highest rise of energy, turnover [J].

    `rise` is the largest growth of the stored energy beyond the work put in, `turnover` the
    largest change of any one kind of energy or of the work.
    """

    closest: float
    rise: float
    turnover: float

    def __str__(self):
        """Return it in words."""
        near = f"closest {self.closest:.3f} of touching, " if np.isfinite(self.closest) else ""
        return f"{near}energy rose by {self.rise / max(self.turnover, 1e-300):.1e} of its turnover"


def watch(march, duration, *, rise=0.08, scale=0.0, looks=20, separate=SEPARATE, tracked=True):
    """March on and assert, look by look, what must hold in every hard case.

    All is finite; no strand comes closer to another than `separate` of the contact distance, and
    none moves so far between two looks that it could have passed through and out again (unless the
    test proves that another way: `tracked=False`); energy less the work put in never grows by more
    than `rise` of what has been turned over, or of `scale` [J] if that is more. Position Verlet
    swings about the true energy by some (omega dt)^2/16, 3 % while a contact lasts at 0.75 of the
    largest step, and gives it back.
    """
    scene, state, end = march.scene, march.state, march.time + duration
    reach = 2 * min(each.radius for each in scene.rods)
    touching = len(scene.rods) > 1 or scene.contact.self_contact
    tracked = tracked and touching
    nearest, books, span = closest(march), [energies(march)], 2 * march.dt
    while march.time < end - 0.5 * march.dt:
        before = state.rows("X0 X1 X2")
        span = next_look(march, duration / looks, reach, span) if tracked else duration / looks
        march.advance(max(1, round(min(span, end - march.time) / march.dt)))
        _assert_finite(state)
        books.append(energies(march))
        if touching:
            moved = np.linalg.norm(state.rows("X0 X1 X2") - before, axis=0).max()
            assert moved < 0.5 * reach or not tracked, f"moved {moved / reach:.2f} diameters unseen"
            nearest = min(nearest, closest(march))
            assert nearest > separate, f"t = {march.time:g} s: {nearest:.3f} of touching"
    balance = np.sum(books, axis=1)
    risen = float(np.max(balance - np.minimum.accumulate(balance)))
    turnover = max(scale, float(np.ptp(books, axis=0).max()))
    assert risen <= rise * turnover, f"energy rose by {risen / turnover:.2e} of its turnover"
    return Watch(nearest, risen, turnover)


def next_look(march, longest, reach, last):
    """Return after how long to look again [s]: before anything has moved a good part of `reach`."""
    fastest = np.linalg.norm(march.state.rows("V0 V1 V2"), axis=0).max()
    return min(longest, 2 * last, max(0.2 * reach / max(fastest, 1e-300), 2 * march.dt))


def _assert_finite(state):
    names = "X0 X1 X2 V0 V1 V2 W0 W1 W2 Q00 Q01 Q02 Q10 Q11 Q12 Q20 Q21 Q22"
    assert np.isfinite(state.rows(names)).all()


def momentum(march):
    """Return the total momentum [N s], (3,)."""
    return (march.state.row("MASS") * march.state.rows("V0 V1 V2")).sum(axis=1)


def largest_speed(march):
    """Return the speed of the fastest node [m/s]."""
    return float(np.linalg.norm(march.state.rows("V0 V1 V2"), axis=0).max())


def show(case, measured):
    """Print a row for docs/sim_hard_cases.md: `pytest tests/sim/test_hard_*.py -s | grep '^|'`."""
    print(f"\n| {case} | {measured} |")
