"""The tine's radius matters little."""

from combing.claims.claim import Claim
from combing.claims.measures import ratio_of_ends

CLAIM = Claim(
    sentence="The radius of the tine matters little.",
    where="text before Fig. 2; SI",
    over="pi3",
    quantity="f_max with the thickest tine over that with the thinnest",
    measure=ratio_of_ends,
    above=0.8,
    below=1.25,
)
