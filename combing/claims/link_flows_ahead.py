"""Link flows through the tine: hardly any stays behind."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="Link flows from the clamped to the free side of the tine.",
    where="Figs. 2e, 3e",
    over="pi1",
    quantity="mean link density behind the tine over the first, x from 0.3 to 0.9",
    measure=mean("behind"),
    below=0.3,
)
