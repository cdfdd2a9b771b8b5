"""Where each quantity lives: rows of one float64 buffer with a constant pitch.

All rods lie one after another. Node i has element i between it and node i + 1, and vertex i between
elements i - 1 and i. Between the last node of a rod and the first of the next are a node without
mass and two ghost elements, the frames of their clamps: their coefficients are zero, so loops run
over everything without a branch.

The row pitch is a compile-time constant, so the compiler sees that two rows never overlap and
vectorises without alias checks. It is no power of two, because rows a multiple of 4096 bytes apart
share the same cache sets.
"""

CAPACITY = 131072
PITCH = CAPACITY + 136

_NODES = "X0 X1 X2 V0 V1 V2 F0 F1 F2 MASS INV_MASS"
_ELEMENTS = "Q00 Q01 Q02 Q10 Q11 Q12 Q20 Q21 Q22 W0 W1 W2 C0 C1 C2"
_CONSTANTS = "INV_LENGTH LENGTH SHEAR STRETCH INV_J1 INV_J3 J_RATIO RADIUS"
_WORK = "N0 N1 N2 T0 T1 T2 E0 E1 E2"
_VERTICES = "INV_VORONOI BEND TWIST K0 K1 K2 L0 L1 L2 R0 R1 R2"
_CONTACT = "PREVIOUS NEXT B0 B1 B2 OVERHANG A0 A1 A2 G0 G1 G2 ROAM SWAY"
_NAMES = " ".join((_NODES, _ELEMENTS, _CONSTANTS, _WORK, _VERTICES, _CONTACT)).split()
ROWS = len(_NAMES)
ROW = {name: number for number, name in enumerate(_NAMES)}

# Nodes: position [m], velocity [m/s], force other than the internal one [N], mass [kg] and its
# inverse (0 where the node is held).
X0, X1, X2 = (PITCH * ROW[name] for name in ("X0", "X1", "X2"))
V0, V1, V2 = (PITCH * ROW[name] for name in ("V0", "V1", "V2"))
F0, F1, F2 = (PITCH * ROW[name] for name in ("F0", "F1", "F2"))
MASS, INV_MASS = (PITCH * ROW[name] for name in ("MASS", "INV_MASS"))

# Elements: directors d1, d2, d3 as rows of Q, angular velocity in the body frame [rad/s], couple in
# the body frame [N m], rest length [m], rigidities alpha G A and E A [N], inverse rotary inertia
# [1/(kg m^2)] about d1, d2 and about d3 (0 where the element is held), J3/J1 - 1, radius [m].
Q00, Q01, Q02 = (PITCH * ROW[name] for name in ("Q00", "Q01", "Q02"))
Q10, Q11, Q12 = (PITCH * ROW[name] for name in ("Q10", "Q11", "Q12"))
Q20, Q21, Q22 = (PITCH * ROW[name] for name in ("Q20", "Q21", "Q22"))
W0, W1, W2 = (PITCH * ROW[name] for name in ("W0", "W1", "W2"))
C0, C1, C2 = (PITCH * ROW[name] for name in ("C0", "C1", "C2"))
INV_LENGTH, LENGTH = (PITCH * ROW[name] for name in ("INV_LENGTH", "LENGTH"))
SHEAR, STRETCH = (PITCH * ROW[name] for name in ("SHEAR", "STRETCH"))
INV_J1, INV_J3, J_RATIO = (PITCH * ROW[name] for name in ("INV_J1", "INV_J3", "J_RATIO"))
RADIUS = PITCH * ROW["RADIUS"]

# Elements, work space: internal force in the lab frame [N], unit tangent, shear couple [N m].
N0, N1, N2 = (PITCH * ROW[name] for name in ("N0", "N1", "N2"))
T0, T1, T2 = (PITCH * ROW[name] for name in ("T0", "T1", "T2"))
E0, E1, E2 = (PITCH * ROW[name] for name in ("E0", "E1", "E2"))

# Vertices: inverse Voronoi length [1/m], bending and twisting rigidity [N m^2], rest curvature
# [1/m], and the couples [N m] that the vertex puts on the element left and right of it.
INV_VORONOI, BEND, TWIST = (PITCH * ROW[name] for name in ("INV_VORONOI", "BEND", "TWIST"))
K0, K1, K2 = (PITCH * ROW[name] for name in ("K0", "K1", "K2"))
L0, L1, L2 = (PITCH * ROW[name] for name in ("L0", "L1", "L2"))
R0, R1, R2 = (PITCH * ROW[name] for name in ("R0", "R1", "R2"))

# Contact: which tangents the wedge normal of a node adds up (1 or 0), the normal, how far a rod's
# end reaches beyond its last node [m], positions when the neighbour list was built and when the
# pairs in play were last sieved out of it, how far a node may move until that is done again, and
# the most that any node may that an element and its part of space depend on [m].
PREVIOUS, NEXT = (PITCH * ROW[name] for name in ("PREVIOUS", "NEXT"))
B0, B1, B2 = (PITCH * ROW[name] for name in ("B0", "B1", "B2"))
OVERHANG = PITCH * ROW["OVERHANG"]
A0, A1, A2 = (PITCH * ROW[name] for name in ("A0", "A1", "A2"))
G0, G1, G2 = (PITCH * ROW[name] for name in ("G0", "G1", "G2"))
ROAM, SWAY = (PITCH * ROW[name] for name in ("ROAM", "SWAY"))
