"""Friction changes the level of the curve, not its shape."""

from combing.claims.claim import Claim
from combing.claims.measures import ratio_of_fullness

CLAIM = Claim(
    sentence="Friction changes the level of the force, not the shape of its curve.",
    where="footnotes",
    over="friction",
    quantity="mean over highest force with most friction, over the same with least",
    measure=ratio_of_fullness,
    above=0.8,
    below=1.25,
)
