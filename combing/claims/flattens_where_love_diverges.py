"""The force stays finite where a single stretched helix diverges."""

from combing.claims.claim import Claim
from combing.claims.measures import share

CLAIM = Claim(
    sentence="The force flattens where that of a single helix, stretched as far, diverges.",
    where="text after Fig. 2",
    over="pi1",
    quantity="share of curves within whose stroke Love's helix needs ten times their highest force",
    measure=share("love_diverges", lambda value: value > 0),
    above=0.5,
)
