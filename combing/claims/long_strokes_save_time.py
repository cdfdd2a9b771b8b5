"""C(q) falls at gamma = 0."""

from combing.claims.claim import Claim, Finding

CLAIM = Claim(
    sentence="Where time alone counts, long strokes cost least.",
    where="Fig. 4c, gamma = 0",
    over="q",
    quantity="b of C ~ q^b at gamma = 0, where C = q0/q",
    measure=lambda curves: Finding(-1.0, -1.0, -1.0),
    below=0.0,
    by_definition=True,
)
