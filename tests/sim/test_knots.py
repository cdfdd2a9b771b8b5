"""Strands that touch themselves: overhand knots, plectonemes, solenoids.

Friction is Coulomb's and the rods are straight at rest. A knot's numbers are those of Audoly,
Clauvelin & Neukirch, PRL 99, 164301 (2007), and Jawed, Dieleman, Audoly & Reis, PRL 115, 118302
(2015), with h the strand's radius, B its bending rigidity and F the traction on its tails.
"""

import math
from functools import cache, partial

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.special import ellipe, ellipk

from sim.energy import directors
from sim.errors import Unstable
from sim.march.state import rigidities
from sim.scene import Contact, End, Friction, Material, Motion
from sim.scene.shapes import helix, smallest_turn
from sim.topology import writhe

from .hard import SOFT, closest, line, march_of, rod, segment_distances, show, watch

H = 5e-3
B, _ = rigidities(SOFT, H)
SIGMA = 0.492  # friction constant of the trefoil, Audoly et al.


def audoly(R, mu):
    """Return F h^2/B = eps^4/2 + mu sigma eps^3, eps = sqrt(h/R), for a sliding overhand knot.

    The first term is the loop's: its energy pi B/R against the length 2 pi R that it takes up
    gives F = B/(2 R^2). Leading order in eps and in mu.
    """
    eps = math.sqrt(H / R)
    return 0.5 * eps**4 + mu * SIGMA * eps**3


def jawed(shortening, mu, n):
    """Return F h^2/B of an overhand knot with n turns in its braid, eq. (5) of Jawed et al.

    Friction in a long braid, a helix of wave number (sqrt(12) h R)^(-1/2), against a loop that is
    an elastica: with x = l/R, braid over end radius, n^2 h/e = x^2/(x + lambda/R)/(8 sqrt3 pi^2),
    n^2 F h^2/B = mu x^3/(96 sqrt3 pi^2). The loop's first integral kappa^2 R^2 = 1 - m sin^2(th/2)
    gives lambda/R = 4 K(m) and x = 8 (K(m) - E(m))/m - 4 K(m).
    """
    m = 1 - np.geomspace(0.999, 1e-12, 2000)
    loop, x = 4 * ellipk(m), 8 * (ellipk(m) - ellipe(m)) / m - 4 * ellipk(m)
    scale = math.sqrt(3) * math.pi**2
    ratio = x**2 / (x + loop) / (8 * scale)
    return np.interp(n**2 * H / shortening, ratio, mu * x**3 / (96 * scale)) / n**2


def overhand(n, R, tail, spacing):
    """Return nodes of an overhand knot whose braid has n turns, drawn loose, tails along z.

    One strand winds up through the braid, goes round in a stadium of radius R and comes up through
    the braid as the other. Right-handed, with the loop to +y: 2 n + 1 alternating crossings.
    """
    apart = 1.15 * H
    braid = 2 * math.pi * n * math.sqrt(math.sqrt(12) * H * R)
    z, turn = np.linspace(-0.5, 0.5, 400 * n) * braid, np.linspace(0, math.pi, 300)[1:]
    angle = 2 * math.pi * n * (z / braid + 0.5)
    up = np.column_stack([apart * np.cos(angle), apart * np.sin(angle), z])
    top = np.column_stack([R * (1 - np.cos(turn)), 0.5 * braid + R * np.sin(turn)])
    down = np.column_stack([np.full(200, 2 * R), np.linspace(0.5, -0.5, 200) * braid])[1:]
    bottom = np.column_stack([R * (1 + np.cos(turn)), -0.5 * braid - R * np.sin(turn)])
    loop = np.vstack([top, down, bottom])
    share = np.linspace(0, 1, len(loop))
    across = apart * (1 - 2 * share**2 * (3 - 2 * share))
    tails = np.linspace(0, tail, 300)[1:, None] * [0, 0, 1]
    path = np.vstack(
        [up[0] - tails[::-1], up, np.column_stack([across, loop])[:-1], -up * [1, 1, -1],
         [-apart, 0, 0.5 * braid] + tails]
    )  # fmt: skip
    return evenly(path, spacing)


def evenly(path, spacing):
    """Return nodes `spacing` apart along a path, its corners rounded, its ends as they are."""
    arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    s = np.linspace(0, arc[-1], round(arc[-1] / spacing) + 1)
    nodes = np.column_stack([np.interp(s, arc, path[:, k]) for k in range(3)])
    smooth = gaussian_filter1d(nodes, 4 * H / spacing, axis=0, mode="nearest")
    smooth[:5], smooth[-5:] = nodes[:5], nodes[-5:]
    return smooth


def knotted(nodes, *, pull=0.0, speed=0.0, mu=None, **others):
    """Return a march of a knot whose pinned ends are drawn apart by `pull` [m] each."""
    ends = [
        End(hold="pinned", motion=Motion(velocity=(0, 0, v), ramp=1.0, duration=pull / speed))
        if pull
        else End(hold="pinned", motion=Motion())
        for v in (-speed, speed)
    ]
    friction = None if mu is None else Friction(forward=mu, backward=mu)
    return march_of(
        rod(nodes, H, root=ends[0], tip=ends[1], rest="straight"), viscous=3e-5,
        contact=Contact(self_contact=True), rotary_inertia="element", friction=friction, **others,
    )  # fmt: skip


def measured(march):
    """Return traction [N], end radius and mean radius of the loop, and shortening [m] of a knot.

    The traction is that of the tails next to the knot; the end radius the smallest, where the
    strand leaves the braid; the mean one that of the circle with the loop's area.
    """
    state = march.state
    at, x = state.nodes(0), state.strands()[0]
    chord = np.diff(x, axis=0)
    length = np.linalg.norm(chord, axis=1)
    tangent = chord / length[:, None]
    tension = np.einsum("ij,ij->i", state.rows("N0 N1 N2").T[at][:-1], tangent)
    touching = np.flatnonzero((apart_along(march, x) < 2.02 * H).any(axis=1))
    first, last = touching[0], touching[-1]
    tails = np.r_[first - 12 : first - 4, last + 5 : last + 13]
    bend = np.linalg.norm(np.cross(tangent[:-1], tangent[1:]), axis=1)
    bend = np.convolve(2 * bend / (length[1:] + length[:-1]), np.ones(3) / 3, "same")
    split = np.argmax(np.diff(touching))  # the longest stretch without contact is the loop
    loop = x[touching[split] : touching[split + 1] + 2]
    area = 0.5 * np.linalg.norm(np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0))
    shortening = state.row("LENGTH")[at][:-1].sum() - np.linalg.norm(x[-1] - x[0])
    tightest = 1 / bend[first - 5 : last + 5].max()
    return tension[tails].mean(), tightest, math.sqrt(area / math.pi), shortening


def apart_along(march, x, h=H):
    """Return the distances of all pairs of segments, infinite for those near along the strand."""
    number = np.arange(len(x) - 1)
    near = abs(number - number[:, None]) * march.state.row("LENGTH")[1] < 2 * math.pi * h
    return np.where(near, np.inf, segment_distances(x, x))


@pytest.mark.parametrize("R_over_h", [12, 30])
def test_overhand_knot_held_loose_without_friction_pulls_with_B_over_2_R2(R_over_h):
    """The loop is a circle in the limit only: at 20 to 50 h its ends bend more than its middle.

    B/2R^2 with the radius at its ends is more than the traction, with its mean radius less, and
    with the mean of both it is within 10 %.
    """
    spacing = 2 * H if R_over_h < 20 else 3 * H
    march = knotted(overhand(1, R_over_h * H, 40 * H, spacing), drag=8 * (12 / R_over_h) ** 1.5)
    seen = watch(march, 5.0 * (R_over_h / 12) ** 1.5, looks=40, tracked=False)
    force, ends, mean, _ = measured(march)
    at_ends, at_mean = (force * H**2 / B / audoly(R, 0.0) for R in (ends, mean))
    assert at_ends < 1 < at_mean
    assert math.sqrt(at_ends * at_mean) == pytest.approx(1, abs=0.1)
    show(
        f"overhand knot held, no friction, R = {ends / H:.0f} to {mean / H:.0f} h",
        f"{seen}, F 2R^2/B = {at_ends:.3f} to {at_mean:.3f}",
    )


@cache
def sliding(mu, loose, tightens):
    """Return F h^2/B, end radius and mean radius over h of an overhand knot while it slides.

    Drawn, let swing out, and then seen from 86 down to 74 or from 30 to 25 h; or loosened the same
    way back: the ends come nearer, and friction holds back what F pulls.
    """
    start, spacing, tail, speed, drag, wait = (
        (72 if tightens else 54, 3 * H, 130 * H, 0.003, 0.15, 30)
        if loose
        else (24 if tightens else 14, 2 * H, 80 * H, 0.01, 0.3, 8)
    )
    away = speed if tightens else -speed
    march = knotted(
        overhand(1, start * H, tail, spacing), pull=100 * away, speed=away, mu=mu, drag=drag
    )
    march.advance(round(wait / march.dt))
    seen = []
    for _ in range(72):
        watch(march, 2.5e-3 / speed, looks=1, tracked=False)
        force, ends, mean, _ = measured(march)
        seen.append((force * H**2 / B, ends / H, mean / H))
    return np.array(seen)


def both_ways(mu, loose):
    """Return half the sum and half the difference of F h^2/B when a knot tightens and loosens at
    one end radius, that radius and the mean one over h.
    """
    runs = [sliding(mu, loose, tightens) for tightens in (True, False)]
    ends = 0.5 * (max(run[:, 1].min() for run in runs) + min(run[:, 1].max() for run in runs))
    fits = [np.polyfit(np.log(run[:, 1] / ends), run, 2)[-1] for run in runs]
    pull, back = (fit[0] for fit in fits)
    return 0.5 * (pull + back), 0.5 * (pull - back), ends, 0.5 * (fits[0][2] + fits[1][2])


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.05, 0.1])
def test_overhand_knot_pulled_from_R_86_to_74_h_slides_as_audoly_et_al_say(mu):
    """Mean traction over the formula with the radius at the loop's ends, within 10 %."""
    force, ends, _ = sliding(mu, True, True).T
    ratio = np.mean(force / [audoly(R * H, mu) for R in ends])
    assert ratio == pytest.approx(1, abs=0.1)
    show(f"overhand knot sliding, mu = {mu}, eps = 0.11", f"F/Audoly = {ratio:.3f}")


@pytest.mark.slow
def test_an_overhand_knot_tightened_and_loosened_at_mu_0p05_tells_loop_and_friction_apart():
    """At one end radius F changes by twice the friction, and half the sum is the loop's.

    The loop's is B/2R^2 with the two radii multiplied for R^2. Friction is made in the braid, which
    knows the loop by its curvature at the end; the formula is the limit of small eps, and what is
    seen is linear in eps to it.
    """
    eps, friction = [], []
    for loose in (False, True):
        loop, rubbing, ends, mean = both_ways(0.05, loose)
        assert loop * 2 * ends * mean == pytest.approx(1, abs=0.05)
        eps.append(ends**-0.5)
        friction.append(rubbing / (0.05 * SIGMA * ends**-1.5))
        show(
            f"overhand knot tightened and loosened, mu = 0.05, R = {ends:.0f} h",
            f"loop {loop * 2 * ends * mean:.3f}, friction {friction[-1]:.3f} of theory",
        )
    limit = friction[1] - eps[1] * (friction[0] - friction[1]) / (eps[0] - eps[1])
    assert limit == pytest.approx(1, abs=0.1)
    show("the same, extrapolated to eps = 0", f"friction {limit:.3f} of theory")


@pytest.mark.slow
def test_overhand_knot_of_3_turns_slides_as_jawed_et_al_say_at_mu_0p12():
    """Traction against shortening within 10 % of eq. (5), no radius to be measured."""
    n, mu = 3, 0.12
    nodes = overhand(n, 50 * H, 120 * H, 3 * H)
    march = knotted(nodes, pull=150 * H, speed=0.02, mu=mu, drag=0.3)
    march.advance(round(14 / march.dt))
    ratios = []
    for _ in range(10):
        seen = watch(march, 1.5, looks=1, tracked=False)
        force, _, _, shortening = measured(march)
        ratios.append(force * H**2 / B / jawed(shortening, mu, n))
    assert np.mean(ratios) == pytest.approx(1, abs=0.1)
    show("overhand knot of 3 turns sliding, mu = 0.12", f"{seen}, F/Jawed = {np.mean(ratios):.3f}")


@pytest.mark.slow
@pytest.mark.parametrize("mu", [None, 0.1])
def test_overhand_knot_pulled_tight_from_18_to_below_5_h(mu):
    """It stays a knot: the traction grows all the way, and its strands stay out of each other."""
    nodes = overhand(1, 12 * H, 60 * H, 2 * H)
    march = knotted(nodes, pull=60 * H, speed=0.02, mu=mu, drag=1.0)
    forces, seen = [], None
    for _ in range(5):
        seen = watch(march, 3.0, looks=30, tracked=False)
        forces.append(measured(march)[0])
    assert (np.diff(forces[1:]) > 0).all()
    radius = measured(march)[1]
    assert radius < 5 * H
    show(f"overhand knot pulled to R = {radius / H:.1f} h, mu = {mu}", f"{seen}")


def turns_of(march):
    """Return twist and writhe of a clamped rod in turns, its ends prolonged along the clamps.

    The twist adds up the angles between neighbouring frames after parallel transport from chord to
    chord, so that twist + writhe of the polyline is the turns put in, to rounding, as long as no
    strand passes through another; each passage would change the sum by 2.
    """
    state = march.state
    at, x = state.nodes(0), state.strands()[0]
    frames = directors(state, slice(at.start - 1, at.stop))  # with the clamps' own
    chords = np.diff(x, axis=0)
    chords /= np.linalg.norm(chords, axis=1, keepdims=True)
    chords = np.vstack([frames[0, 2], chords, frames[-1, 2]])
    normals = frames[:, 0] - np.einsum("ij,ij->i", frames[:, 0], chords)[:, None] * chords
    angle = 0.0
    for before, after, a, b in zip(chords, chords[1:], normals, normals[1:], strict=False):
        carried = smallest_turn(before, after) @ a
        angle += np.arctan2(np.cross(carried, b) @ after, carried @ b)
    far = 1e4 * np.linalg.norm(x[-1] - x[0])
    ends = x[0] - far * frames[0, 2], x[-1] + far * frames[-1, 2]
    return angle / (2 * math.pi), writhe(np.vstack([ends[0], x, ends[1]]))


def wound(length, elements, turns, spin, feed, *, stretch=0.0, start=0.0, **others):
    """Return a march of a straight clamped rod: one end turns, the other follows by `feed` [m]."""
    ramp, duration = 0.02, 2 * math.pi * turns / spin + 0.02
    nodes = line([0, 0, 0.5 * length], [0, 0, 1], length, elements)
    nodes[2:-2, :2] += 1e-3 * H * np.random.default_rng(1).standard_normal((elements - 3, 2))
    follow = Motion(velocity=(0, 0, feed / (duration - start - ramp)), start=start, ramp=ramp,
                    duration=duration - start)  # fmt: skip
    turn = Motion(spin=(0, 0, spin), ramp=ramp, duration=duration)
    march = march_of(
        rod(nodes, H, Material(E=1e6, nu=0.5, density=1000, G=others.pop("G", None)),
            root=End(hold="clamped", motion=follow), tip=End(hold="clamped", motion=turn),
            rest="straight"),
        viscous=3e-5, rotary_inertia="element",
        contact=Contact(self_contact=True, stiffness=others.pop("stiffness", None)), **others,
    )  # fmt: skip
    march.state.row("X2")[march.state.nodes(0)] *= 1 + stretch
    return march, duration


def kinds_of_contact(march, h=H):
    """Return by how much sum and difference of the numbers of touching segments vary."""
    apart = apart_along(march, march.state.strands()[0], h)
    first, second = np.nonzero(np.triu(apart < 2.02 * h))
    return np.std(first + second), np.std(second - first)


def test_plectoneme_from_12_turns_put_into_a_rod_of_160_radii_with_30_percent_slack():
    """Twist from the frames plus writhe of the centreline are the 12 turns; the strands that touch
    lie opposite each other about the loop at the end.
    """
    march, duration = wound(160 * H, 80, 12, 20.0, 0.3 * 160 * H, drag=10)
    seen = watch(march, duration + 0.5, looks=60, tracked=False)
    twist, writhing = turns_of(march)
    assert twist + writhing == pytest.approx(12, abs=1e-3)
    assert writhing > 3
    sums, differences = kinds_of_contact(march)
    assert sums < 1 < 3 < differences
    show("plectoneme, 12 turns put in", f"{seen}, Tw {twist:.3f} + Wr {writhing:.3f}")


def test_plectoneme_under_tension_with_9_turns_keeps_them_in_loops_as_tight_as_pi_r():
    """Stretched by 3 %, contact stiff: its end loop is too tight for contact to begin 2 pi r along
    the strand; with that exclusion it passed through itself and lost 2 turns.
    """
    march, duration = wound(80 * H, 80, 9, 10.0, 40 * H, stretch=0.03, start=1.5, drag=30, G=1e6,
                            stiffness=3e6, safety=0.5)  # fmt: skip
    seen = watch(march, duration, looks=60, tracked=False)
    twist, writhing = turns_of(march)
    assert twist + writhing == pytest.approx(9, abs=1e-3)
    show("plectoneme under tension, 9 turns put in", f"{seen}, Tw {twist:.3f} + Wr {writhing:.3f}")


THICK, READY = 0.025, 5.0  # radius of a rod of length 1 [m]; when it is turned [s]
STUFF = Material(E=1e6, nu=0.5, G=1e6 / 1.5, density=1 / (math.pi * THICK**2))


def twisted_under_a_load(load, turns, time):
    """Return a march of a rod of 40 radii (Gazzola et al. 2018) whose tip is turned, and its looks.

    Each look marches on and returns the turns put in so far. The root follows the dead `load` [N]
    as an end does that sends no waves back and does not turn, at the load less the tension over
    sqrt(E A rho A).
    """
    nodes = line([0, 0, 0.5], [0, 0, 1], 1.0, 100)
    nodes[2:-2, :2] += 1e-4 * THICK * np.random.default_rng(1).standard_normal((97, 2))
    spin, ramp = 2 * math.pi * turns / time, 0.1
    turn = Motion(spin=(0, 0, spin), start=READY, ramp=ramp, duration=time + ramp)
    march = march_of(
        rod(nodes, THICK, STUFF, root=End(hold="clamped", motion=Motion()),
            tip=End(hold="clamped", motion=turn), rest="straight"),
        drag=500, viscous=3e-5, contact=Contact(self_contact=True, stiffness=3e6), safety=0.6,
    )  # fmt: skip
    driven, impedance = march.effects.driven, math.sqrt(STUFF.E * math.pi * THICK**2)

    def look(until):
        while march.time < until:
            driven.reaction[:] = 0
            some = round(2e-3 / march.dt)
            march.advance(some)
            now = load * min(1, march.time / (0.8 * READY))
            driven.motion[0, 2] = (driven.reaction[0, 2] / some - now) / impedance
        return min(max(0.0, turns * (march.time - READY - 0.5 * ramp) / time), turns)

    return march, [partial(look, until) for until in np.linspace(0, READY + ramp + time, 41)[1:]]


@pytest.mark.slow
def test_plectoneme_from_8_turns_put_into_a_rod_of_40_radii_under_a_load_of_5_percent_strain():
    """It buckles and winds up until a tenth of it is left; at every time twist + writhe are the
    turns put in. (At the ninth it climbs over its clamp, which gives two back.)
    """
    march, looks = twisted_under_a_load(0.05 * STUFF.E * math.pi * THICK**2, 8.0, 20.0)
    for look in looks:
        assert look() == pytest.approx(sum(turns_of(march)), abs=2e-3)
    twist, writhing = turns_of(march)
    assert writhing > 3
    assert closest(march) > 0.9
    sums, differences = kinds_of_contact(march, THICK)
    assert 4 * sums < differences  # wound to the ends, a few of its contacts are those of coils
    show("plectoneme under a dead load, 8 turns put in", f"Tw {twist:.3f} + Wr {writhing:.3f}")


@pytest.mark.slow
def test_a_rod_bent_more_tightly_than_its_radius_is_named_before_it_loses_turns():
    """15 % strain: it buckles under the couple 2 sqrt(B F) = 1.5 B/r, so into a kink, within which
    a rod cannot touch itself. Two turns went with every kink.
    """
    load = 0.15 * STUFF.E * math.pi * THICK**2
    march, looks = twisted_under_a_load(load, 10.0, 25.0)
    with pytest.raises(Unstable, match="passes through itself") as caught:
        [look() for look in looks]
    assert (caught.value.effect, caught.value.mode) == ("elasticity", "bending")
    assert 0 < caught.value.partner[1] - caught.value.element < math.pi * THICK / 0.01
    put_in = 10.0 * (march.time - READY - 0.05) / 25.0
    assert sum(turns_of(march)) == pytest.approx(put_in, abs=0.01)
    bend, twist = rigidities(STUFF, THICK)
    assert put_in == pytest.approx(math.sqrt(bend * load) / (math.pi * twist), rel=0.05)


def test_solenoid_of_4_touching_coils_pulled_to_90_percent_turns_writhe_into_twist():
    """A coil spring, wound closely, its ends clamped: while it is pulled out, its writhe becomes
    twist, and at every time the sum of both is what it was.
    """
    radius, coils, pitch = 4 * H, 4, 2.0 * H
    nodes = helix(radius, pitch, coils * pitch, 20 * coils)
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    pull, speed = 0.9 * length - coils * pitch, 0.1
    away = Motion(velocity=(0, 0, -speed), ramp=0.1, duration=pull / speed + 0.1)
    still, pulled = End(hold="clamped", motion=Motion()), End(hold="clamped", motion=away)
    march = march_of(
        rod(nodes, H, root=still, tip=pulled), drag=20, viscous=3e-5,
        contact=Contact(self_contact=True), rotary_inertia="element",
    )  # fmt: skip
    start = turns_of(march)
    sums, differences = kinds_of_contact(march)
    assert differences < 1 < 10 < sums  # every turn touches the next, all along
    total, seen = [], None
    for _ in range(10):
        seen = watch(march, away.duration / 10, looks=5, tracked=False)
        total.append(turns_of(march))
    np.testing.assert_allclose(np.sum(total, axis=1), sum(start), atol=1e-3)
    twist, writhing = total[-1]
    assert start[1] > 3.5 > 0.5 > writhing
    show("solenoid of 4 coils pulled out", f"{seen}, Tw {twist:.3f} + Wr {writhing:.3f}")
