"""Smaller pitch, larger force."""

from combing.claims.claim import Claim
from combing.claims.measures import exponent

CLAIM = Claim(
    sentence="The tighter the pitch, the larger the force it takes to comb.",
    where="Figs. 2c and 3c",
    over="pi1",
    quantity="b of f_max ~ (P/r)^b",
    measure=exponent,
    below=0.0,
)
