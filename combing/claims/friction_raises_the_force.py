"""Friction changes the level of the force."""

from combing.claims.claim import Claim
from combing.claims.measures import ratio_of_ends

CLAIM = Claim(
    sentence="Friction between the strands raises the force.",
    where="footnotes on friction",
    over="friction",
    quantity="f_max at the largest coefficient over that at the smallest",
    measure=ratio_of_ends,
    above=1.0,
)
