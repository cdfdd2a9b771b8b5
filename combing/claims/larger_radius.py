"""Smaller helix radius, larger force."""

from combing.claims.claim import Claim
from combing.claims.measures import exponent

CLAIM = Claim(
    sentence="At one pitch, the larger the radius of the helix, the smaller the force.",
    where="Figs. 2d and 3d",
    over="pi2",
    quantity="b of f_max ~ (R/r)^b",
    measure=exponent,
    below=0.0,
)
