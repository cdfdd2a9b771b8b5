"""Link density steps up across the tine."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="The link density steps up across the tine.",
    where="Figs. 2e, 3e",
    over="pi1",
    quantity="jump between the means over a pitch on either side, over the first link density, "
    "x from 0.2 to 0.9",
    measure=mean("jump"),
    above=0.1,
)
