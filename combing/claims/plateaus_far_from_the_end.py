"""Plateaus where combing starts more than 4 or 5 pitches from the free end."""

from combing.claims.claim import Claim
from combing.claims.measures import share

CLAIM = Claim(
    sentence="Combing from more than 5 pitches above the free end, the force has plateaus.",
    where="Figs. 4a and 4b",
    over="q",
    quantity="share of curves with a plateau, q > 5",
    measure=share("plateaus", lambda value: value > 5),
    above=0.5,
)
