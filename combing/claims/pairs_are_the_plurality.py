"""Pairs are the commonest interaction."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="Interactions of pairs are the plurality of those in a curl.",
    where="Fig. 1d, 3b",
    over="N",
    quantity="interactions of two strands less those of the next most frequent N, over all",
    measure=mean("lead_of_pairs"),
    above=0,
)
