"""C(q) rises at gamma = 1."""

from combing.claims.claim import Claim
from combing.claims.measures import exponent

CLAIM = Claim(
    sentence="Where pain alone counts, short strokes cost least.",
    where="Fig. 4c, gamma = 1",
    over="q",
    quantity="b of C ~ q^b at gamma = 1, where C = f_max",
    measure=exponent,
    above=0.0,
)
