"""The bare rod: drift, internal forces and kick of a geometrically exact (Simo-Reissner) rod.

The discretisation is that of Gazzola et al., R. Soc. Open Sci. 5, 171628 (2018), with strains
measured per rest length and the couples as the exact gradient of the elastic energy

    U = sum_elements 1/2 sigma . S sigma l0 + sum_vertices 1/2 (k - k0) . B (k - k0) D0,
    sigma = Q (x_{i+1} - x_i)/l0 - d3,      k = log(Q_i Q_{i-1}^T)/D0,

so that the undamped rod is Hamiltonian at any strain (see docs/sim.md for the difference).
"""

import math

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403  (row names, nothing else)
from sim.kernels.vectors import along, at, cross, dot, push, put

# theta/sin(theta) as a series in z = sin^2(theta/2): a_{n+1}/a_n = 2(n+1)/(2n+3).
SERIES_LIMIT = 0.06  # theta = 28 degrees; the first term left out is below 1e-16 there

# z at 177 degrees. Beyond half a turn the rotation vector flips over and a turn is lost; a march
# that turns by less than 6 degrees a step cannot get there unseen.
HALF_TURN = math.sin(0.5 * math.radians(177.0)) ** 2


@kernel
def drift(buf, n, dt):
    """Move nodes by v dt and turn elements by the Cayley map of w dt, orthogonal to rounding."""
    drift_nodes(buf, n, dt)
    turn_column(buf, n, dt, Q00, Q10, Q20)
    turn_column(buf, n, dt, Q01, Q11, Q21)
    turn_column(buf, n, dt, Q02, Q12, Q22)


@kernel
def drift_nodes(buf, n, dt):
    """Move nodes by v dt."""
    for i in range(n):
        push(buf, X0, X1, X2, i, at(buf, V0, V1, V2, i), dt)


@kernel
def turn_column(buf, n, dt, q0, q1, q2):
    """Turn one column q of every Q: q <- q - c a x q + c/2 a x (a x q), a = w dt."""
    for i in range(n):
        a = (dt * buf[W0 + i], dt * buf[W1 + i], dt * buf[W2 + i])
        c = 1.0 / (1.0 + 0.25 * dot(a, a))
        put(buf, q0, q1, q2, i, turned(at(buf, q0, q1, q2, i), a, c, 0.5 * c))


@formula
def turned(q, a, first, second):
    """Return q - first a x q + second a x (a x q)."""
    u = cross(a, q)
    return along(along(q, -first, u), second, cross(a, u))


@kernel
def drift_twice(buf, n, dt):
    """Drift by dt two times over in one go, the end of one step and the beginning of the next."""
    drift_nodes(buf, n, 2.0 * dt)
    turn_column_twice(buf, n, dt, Q00, Q10, Q20)
    turn_column_twice(buf, n, dt, Q01, Q11, Q21)
    turn_column_twice(buf, n, dt, Q02, Q12, Q22)


@kernel
def turn_column_twice(buf, n, dt, q0, q1, q2):
    """Turn a column by two equal Cayley maps: with |a| = 2 tan(theta/2) each turns it by theta, and
    sin(2 theta) and 1 - cos(2 theta) are rational in |a|^2.
    """
    for i in range(n):
        a = (dt * buf[W0 + i], dt * buf[W1 + i], dt * buf[W2 + i])
        m = 0.25 * dot(a, a)
        c = 1.0 / (1.0 + m)
        second = 2.0 * c * c
        put(buf, q0, q1, q2, i, turned(at(buf, q0, q1, q2, i), a, second * (1.0 - m), second))


@kernel
def stretch_and_shear(buf, n, viscous):
    """Fill the internal force N = Q^T S sigma [N] and the couple (Q e) x (S sigma) l0 [N m].

    With `viscous`, a time [s], the strain is the Kelvin-Voigt one, sigma + viscous d(sigma)/dt.
    """
    for i in range(n):
        inv = buf[INV_LENGTH + i]
        e0 = (buf[X0 + i + 1] - buf[X0 + i]) * inv
        e1 = (buf[X1 + i + 1] - buf[X1 + i]) * inv
        e2 = (buf[X2 + i + 1] - buf[X2 + i]) * inv
        s0 = buf[Q00 + i] * e0 + buf[Q01 + i] * e1 + buf[Q02 + i] * e2
        s1 = buf[Q10 + i] * e0 + buf[Q11 + i] * e1 + buf[Q12 + i] * e2
        s2 = buf[Q20 + i] * e0 + buf[Q21 + i] * e1 + buf[Q22 + i] * e2
        g0, g1, g2 = s0, s1, s2 - 1.0
        if viscous is not None:
            rate0, rate1, rate2 = strain_rate(buf, i, s0, s1, s2)
            g0, g1, g2 = g0 + viscous * rate0, g1 + viscous * rate1, g2 + viscous * rate2
        n0, n1, n2 = buf[SHEAR + i] * g0, buf[SHEAR + i] * g1, buf[STRETCH + i] * g2
        buf[N0 + i] = buf[Q00 + i] * n0 + buf[Q10 + i] * n1 + buf[Q20 + i] * n2
        buf[N1 + i] = buf[Q01 + i] * n0 + buf[Q11 + i] * n1 + buf[Q21 + i] * n2
        buf[N2 + i] = buf[Q02 + i] * n0 + buf[Q12 + i] * n1 + buf[Q22 + i] * n2
        length = buf[LENGTH + i]
        buf[E0 + i] = (s1 * n2 - s2 * n1) * length
        buf[E1 + i] = (s2 * n0 - s0 * n2) * length
        buf[E2 + i] = (s0 * n1 - s1 * n0) * length


@formula
def strain_rate(buf, i, s0, s1, s2):
    """Return d(sigma)/dt = Q dv/l0 - w x (Q e) in the body frame [1/s]."""
    inv = buf[INV_LENGTH + i]
    d0 = (buf[V0 + i + 1] - buf[V0 + i]) * inv
    d1 = (buf[V1 + i + 1] - buf[V1 + i]) * inv
    d2 = (buf[V2 + i + 1] - buf[V2 + i]) * inv
    w0, w1, w2 = buf[W0 + i], buf[W1 + i], buf[W2 + i]
    return (
        buf[Q00 + i] * d0 + buf[Q01 + i] * d1 + buf[Q02 + i] * d2 - (w1 * s2 - w2 * s1),
        buf[Q10 + i] * d0 + buf[Q11 + i] * d1 + buf[Q12 + i] * d2 - (w2 * s0 - w0 * s2),
        buf[Q20 + i] * d0 + buf[Q21 + i] * d1 + buf[Q22 + i] * d2 - (w0 * s1 - w1 * s0),
    )


@kernel
def bend_and_twist(buf, n, viscous):
    """Fill the couples of every vertex on its two elements, in their body frames [N m].

    Returns how many vertices are about to turn by more than half a turn, which no frames can tell.
    Loops of their own, because a single one is too long for the compiler to inline and vectorise:
    32 ns per vertex instead of 5.
    """
    sharp = turn_between_elements(buf, n)
    rotation_vectors(buf, n)
    wound = 0
    if sharp > 0:
        wound = bend_sharply(buf, n)
    couple_elements(buf, n, viscous)
    return wound


@kernel
def turn_between_elements(buf, n):
    """Store every relative rotation in L0 L1 L2 R1; count those too sharp for the series."""
    sharp = 0
    for i in range(1, n):
        v0, v1, v2, z = relative_rotation(buf, i)
        z = z if buf[INV_VORONOI + i] > 0.0 else 0.0  # no vertex between two rods
        buf[L0 + i], buf[L1 + i], buf[L2 + i], buf[R1 + i] = v0, v1, v2, z
        sharp += 1 if z > SERIES_LIMIT else 0
    return sharp


@kernel
def rotation_vectors(buf, n):
    """Turn the stored relative rotations into rotation vectors (L0 L1 L2) and gamma (R0)."""
    for i in range(1, n):
        ratio = theta_over_sine(buf[R1 + i])
        buf[R0 + i] = second_order(2.0 * buf[R1 + i], ratio)
        buf[L0 + i] = ratio * buf[L0 + i]
        buf[L1 + i] = ratio * buf[L1 + i]
        buf[L2 + i] = ratio * buf[L2 + i]


@kernel
def couple_elements(buf, n, viscous):
    """Turn the stored rotation vectors into couples."""
    for i in range(1, n):
        couple(buf, i, buf[L0 + i], buf[L1 + i], buf[L2 + i], buf[R0 + i], viscous)


@kernel
def bend_sharply(buf, n):
    """Repeat the vertices that turn too far for the series, with the exact logarithm.

    Returns how many turn by nearly half a turn.
    """
    wound = 0
    for i in range(1, n):
        if buf[R1 + i] > SERIES_LIMIT:
            wound += 1 if buf[R1 + i] > HALF_TURN else 0
            p0, p1, p2 = logarithm(buf, i)
            theta = math.sqrt(p0 * p0 + p1 * p1 + p2 * p2)
            buf[L0 + i], buf[L1 + i], buf[L2 + i] = p0, p1, p2
            buf[R0 + i] = (1.0 - 0.5 * theta / math.tan(0.5 * theta)) / (theta * theta)
    return wound


@formula
def relative_rotation(buf, i):
    """Return sin(theta) times the axis of Q_i Q_{i-1}^T, and z = sin^2(theta/2)."""
    b = i - 1
    r00 = buf[Q00 + i] * buf[Q00 + b] + buf[Q01 + i] * buf[Q01 + b] + buf[Q02 + i] * buf[Q02 + b]
    r01 = buf[Q00 + i] * buf[Q10 + b] + buf[Q01 + i] * buf[Q11 + b] + buf[Q02 + i] * buf[Q12 + b]
    r02 = buf[Q00 + i] * buf[Q20 + b] + buf[Q01 + i] * buf[Q21 + b] + buf[Q02 + i] * buf[Q22 + b]
    r10 = buf[Q10 + i] * buf[Q00 + b] + buf[Q11 + i] * buf[Q01 + b] + buf[Q12 + i] * buf[Q02 + b]
    r11 = buf[Q10 + i] * buf[Q10 + b] + buf[Q11 + i] * buf[Q11 + b] + buf[Q12 + i] * buf[Q12 + b]
    r12 = buf[Q10 + i] * buf[Q20 + b] + buf[Q11 + i] * buf[Q21 + b] + buf[Q12 + i] * buf[Q22 + b]
    r20 = buf[Q20 + i] * buf[Q00 + b] + buf[Q21 + i] * buf[Q01 + b] + buf[Q22 + i] * buf[Q02 + b]
    r21 = buf[Q20 + i] * buf[Q10 + b] + buf[Q21 + i] * buf[Q11 + b] + buf[Q22 + i] * buf[Q12 + b]
    r22 = buf[Q20 + i] * buf[Q20 + b] + buf[Q21 + i] * buf[Q21 + b] + buf[Q22 + i] * buf[Q22 + b]
    z = 0.25 * (3.0 - r00 - r11 - r22)
    return 0.5 * (r12 - r21), 0.5 * (r20 - r02), 0.5 * (r01 - r10), z


@formula
def theta_over_sine(z):
    """Return theta/sin(theta) for z = sin^2(theta/2) < SERIES_LIMIT, to 1e-16."""
    total = 1.0 + z * (24.0 / 25.0)
    total = 1.0 + z * (22.0 / 23.0) * total
    total = 1.0 + z * (20.0 / 21.0) * total
    total = 1.0 + z * (18.0 / 19.0) * total
    total = 1.0 + z * (16.0 / 17.0) * total
    total = 1.0 + z * (14.0 / 15.0) * total
    total = 1.0 + z * (12.0 / 13.0) * total
    total = 1.0 + z * (10.0 / 11.0) * total
    total = 1.0 + z * (8.0 / 9.0) * total
    total = 1.0 + z * (6.0 / 7.0) * total
    total = 1.0 + z * (4.0 / 5.0) * total
    return 1.0 + z * (2.0 / 3.0) * total


@formula
def second_order(u, ratio):
    """Return (1 - theta/2 cot(theta/2))/theta^2 from u = 1 - cos(theta), ratio = theta/sin."""
    u = max(u, 1e-12)
    return (1.0 - 0.5 * ratio * (2.0 - u)) / (ratio * ratio * u * (2.0 - u))


@formula
def couple(buf, i, p0, p1, p2, gamma, viscous):
    """Put the couples -dU/dpsi of rotation vector p at vertex i on its two elements.

    With m = B (p/D - k0) they are m + p x m/2 + gamma p x (p x m) on the left element and
    -m + p x m/2 - gamma p x (p x m) on the right one: the transposed inverse derivative of the
    exponential map (Iserles et al., Acta Numerica 9, 215 (2000), eq. 2.46). With `viscous` [s] the
    moment is the Kelvin-Voigt one, B (p/D - k0 + viscous dp/dt/D), and only dissipates.
    """
    inv = buf[INV_VORONOI + i]
    g0, g1, g2 = p0 * inv - buf[K0 + i], p1 * inv - buf[K1 + i], p2 * inv - buf[K2 + i]
    if viscous is not None:
        rate0, rate1, rate2 = turning_rate(buf, i, p0, p1, p2, gamma)
        scale = viscous * inv
        g0, g1, g2 = g0 + scale * rate0, g1 + scale * rate1, g2 + scale * rate2
    m0, m1, m2 = buf[BEND + i] * g0, buf[BEND + i] * g1, buf[TWIST + i] * g2
    u0, u1, u2 = p1 * m2 - p2 * m1, p2 * m0 - p0 * m2, p0 * m1 - p1 * m0
    s0 = m0 + gamma * (p1 * u2 - p2 * u1)
    s1 = m1 + gamma * (p2 * u0 - p0 * u2)
    s2 = m2 + gamma * (p0 * u1 - p1 * u0)
    buf[L0 + i], buf[R0 + i] = 0.5 * u0 + s0, 0.5 * u0 - s0
    buf[L1 + i], buf[R1 + i] = 0.5 * u1 + s1, 0.5 * u1 - s1
    buf[L2 + i], buf[R2 + i] = 0.5 * u2 + s2, 0.5 * u2 - s2


@formula
def turning_rate(buf, i, p0, p1, p2, gamma):
    """Return dp/dt of the rotation vector at vertex i [rad/s], with d and s the difference and the
    sum of the two elements' angular velocities: d + p x s/2 + gamma p x (p x d).
    """
    d0, d1, d2 = (
        buf[W0 + i] - buf[W0 + i - 1],
        buf[W1 + i] - buf[W1 + i - 1],
        buf[W2 + i] - buf[W2 + i - 1],
    )
    s0, s1, s2 = (
        buf[W0 + i] + buf[W0 + i - 1],
        buf[W1 + i] + buf[W1 + i - 1],
        buf[W2 + i] + buf[W2 + i - 1],
    )
    u0, u1, u2 = p1 * d2 - p2 * d1, p2 * d0 - p0 * d2, p0 * d1 - p1 * d0
    return (
        d0 + 0.5 * (p1 * s2 - p2 * s1) + gamma * (p1 * u2 - p2 * u1),
        d1 + 0.5 * (p2 * s0 - p0 * s2) + gamma * (p2 * u0 - p0 * u2),
        d2 + 0.5 * (p0 * s1 - p1 * s0) + gamma * (p0 * u1 - p1 * u0),
    )


@kernel
def logarithm(buf, i):
    """Return the rotation vector of Q_i Q_{i-1}^T for any angle up to pi.

    Through the quaternion, whose largest component is always well determined: exact to rounding
    also at pi, where the antisymmetric part of the matrix vanishes.
    """
    b = i - 1
    v0, v1, v2, z = relative_rotation(buf, i)
    w = math.sqrt(max(1.0 - z, 0.0))
    if w > 0.5:
        q0, q1, q2 = 0.5 * v0 / w, 0.5 * v1 / w, 0.5 * v2 / w
    else:
        q0, q1, q2 = turning_axis(buf, i, b, v0, v1, v2)
        w = 0.5 * (v0 * q0 + v1 * q1 + v2 * q2) / (q0 * q0 + q1 * q1 + q2 * q2)
    sine = math.sqrt(q0 * q0 + q1 * q1 + q2 * q2)
    scale = 2.0 * math.atan2(sine, w) / max(sine, 1e-300)
    return q0 * scale, q1 * scale, q2 * scale


@kernel
def turning_axis(buf, i, b, v0, v1, v2):
    """Return axis sin(theta/2) of a large turn from the symmetric part of Q_i Q_b^T."""
    a1, a2, a3 = directors(buf, i)
    b1, b2, b3 = directors(buf, b)
    d0, d1, d2 = dot(a1, b1), dot(a2, b2), dot(a3, b3)
    s01 = dot(a1, b2) + dot(a2, b1)
    s02 = dot(a1, b3) + dot(a3, b1)
    s12 = dot(a2, b3) + dot(a3, b2)
    if d0 >= d1 and d0 >= d2:
        large = math.sqrt(max(1.0 + d0 - d1 - d2, 0.0))
        q0, q1, q2, sign = 0.5 * large, 0.5 * s01 / large, 0.5 * s02 / large, v0
    elif d1 >= d2:
        large = math.sqrt(max(1.0 + d1 - d0 - d2, 0.0))
        q0, q1, q2, sign = 0.5 * s01 / large, 0.5 * large, 0.5 * s12 / large, v1
    else:
        large = math.sqrt(max(1.0 + d2 - d0 - d1, 0.0))
        q0, q1, q2, sign = 0.5 * s02 / large, 0.5 * s12 / large, 0.5 * large, v2
    if sign < 0.0:
        return -q0, -q1, -q2
    return q0, q1, q2


@kernel
def directors(buf, i):
    """Return d1, d2, d3 of element i in the lab frame."""
    return (
        at(buf, Q00, Q01, Q02, i),
        at(buf, Q10, Q11, Q12, i),
        at(buf, Q20, Q21, Q22, i),
    )


@kernel
def clear_loads(buf, n):
    """Set the forces and couples from outside the rod to zero."""
    for i in range(n):
        buf[F0 + i] = buf[F1 + i] = buf[F2 + i] = 0.0
        buf[C0 + i] = buf[C1 + i] = buf[C2 + i] = 0.0


@kernel
def kick_nodes(buf, n, dt, keep):
    """Change velocities by the internal force diff(N) and the outer force; keep < 1 is drag."""
    for i in range(1, n):
        push = dt * buf[INV_MASS + i]
        buf[V0 + i] = keep * (buf[V0 + i] + push * (buf[F0 + i] + buf[N0 + i] - buf[N0 + i - 1]))
        buf[V1 + i] = keep * (buf[V1 + i] + push * (buf[F1 + i] + buf[N1 + i] - buf[N1 + i - 1]))
        buf[V2 + i] = keep * (buf[V2 + i] + push * (buf[F2 + i] + buf[N2 + i] - buf[N2 + i - 1]))


@kernel
def kick_elements(buf, n, dt, keep):
    """Change angular velocities: half the couple, the free precession, half the couple.

    A symmetric top turns (w1, w2) at the rate (J3/J1 - 1) w3 in its own frame; turning them by a
    Cayley rotation keeps the rotary energy, which adding (J w) x w does not.
    """
    half = 0.5 * dt
    for i in range(n):
        a0 = half * buf[INV_J1 + i] * (buf[C0 + i] + buf[E0 + i] + buf[L0 + i + 1] + buf[R0 + i])
        a1 = half * buf[INV_J1 + i] * (buf[C1 + i] + buf[E1 + i] + buf[L1 + i + 1] + buf[R1 + i])
        a2 = dt * buf[INV_J3 + i] * (buf[C2 + i] + buf[E2 + i] + buf[L2 + i + 1] + buf[R2 + i])
        w0, w1 = buf[W0 + i] + a0, buf[W1 + i] + a1
        t = half * buf[J_RATIO + i] * (buf[W2 + i] + 0.5 * a2)
        c = 1.0 / (1.0 + t * t)
        cosine, sine = (1.0 - t * t) * c, 2.0 * t * c
        buf[W0 + i] = keep * (cosine * w0 - sine * w1 + a0)
        buf[W1 + i] = keep * (sine * w0 + cosine * w1 + a1)
        buf[W2 + i] = keep * (buf[W2 + i] + a2)


@kernel
def kick(buf, n, dt, keep):
    """Change velocities by the forces; drag lets the fraction `keep` of them survive."""
    if keep is not None:
        kick_nodes(buf, n, dt, keep)
        kick_elements(buf, n, dt, keep)
    else:
        kick_nodes(buf, n, dt, 1.0)
        kick_elements(buf, n, dt, 1.0)
