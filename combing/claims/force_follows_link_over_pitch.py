"""Helices that wind up further ahead of the tine need more force."""

from combing.claims.claim import Claim
from combing.claims.measures import rank_correlation

CLAIM = Claim(
    sentence="Over pitches, the highest force follows the link that gathers ahead of the tine.",
    where="abstract",
    over="pi1",
    quantity="rank correlation, over curves, of f_max and the most turns in excess ahead",
    measure=rank_correlation("f_max", "most_excess"),
    above=0.5,
)
