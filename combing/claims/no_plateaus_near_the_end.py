"""No plateaus where combing starts within 4 pitches of the free end."""

from combing.claims.claim import Claim
from combing.claims.measures import share

CLAIM = Claim(
    sentence="Combing from within 4 pitches of the free end, the force has no plateau.",
    where="Figs. 4a and 4b",
    over="q",
    quantity="share of curves with a plateau, q <= 4",
    measure=share("plateaus", lambda value: value <= 4),
    below=0.5,
)
