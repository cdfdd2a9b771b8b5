"""Three-vectors as tuples: the compiler keeps them in registers."""

from sim.kernels.compiled import formula
from sim.kernels.layout import Q00, Q01, Q02, Q10, Q11, Q12, Q20, Q21, Q22, W0, W1, W2


@formula
def at(buf, row0, row1, row2, i):
    """Return the vector stored at index i of three rows."""
    return buf[row0 + i], buf[row1 + i], buf[row2 + i]


@formula
def point(table, i):
    """Return the first three entries of row i of a table as a vector."""
    return table[i, 0], table[i, 1], table[i, 2]


@formula
def put(buf, row0, row1, row2, i, a):
    """Store the vector a at index i of three rows."""
    buf[row0 + i], buf[row1 + i], buf[row2 + i] = a


@formula
def push(buf, row0, row1, row2, i, a, factor):
    """Add factor * a to the vector stored at index i of three rows."""
    buf[row0 + i] += factor * a[0]
    buf[row1 + i] += factor * a[1]
    buf[row2 + i] += factor * a[2]


@formula
def minus(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@formula
def along(a, s, b):
    """Return a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@formula
def dot(a, b):
    """Return a . b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@formula
def cross(a, b):
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@formula
def to_body(buf, i, a):
    """Return Q_i a, the components of a lab vector in the body frame of element i."""
    return (
        dot(at(buf, Q00, Q01, Q02, i), a),
        dot(at(buf, Q10, Q11, Q12, i), a),
        dot(at(buf, Q20, Q21, Q22, i), a),
    )


@formula
def to_lab(buf, i, a):
    """Return Q_i^T a, the lab components of a vector in the body frame of element i."""
    return (
        buf[Q00 + i] * a[0] + buf[Q10 + i] * a[1] + buf[Q20 + i] * a[2],
        buf[Q01 + i] * a[0] + buf[Q11 + i] * a[1] + buf[Q21 + i] * a[2],
        buf[Q02 + i] * a[0] + buf[Q12 + i] * a[1] + buf[Q22 + i] * a[2],
    )


@formula
def spin(buf, i):
    """Return the angular velocity of element i in the lab frame."""
    return to_lab(buf, i, at(buf, W0, W1, W2, i))
