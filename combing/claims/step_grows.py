"""The step grows after x of about 0.2."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="From x of about 0.2 the step of link density across the tine grows.",
    where="text after Fig. 2",
    over="pi1",
    quantity="jump at x from 0.5 to 0.7 less that from 0.15 to 0.25, over the first link density",
    measure=mean("jump_growth"),
    above=0,
)
