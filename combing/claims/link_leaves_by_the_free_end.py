"""What link there was has left by the free end when combing ends."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="Link is expelled by the free end till the strands are unlinked.",
    where="text after Fig. 2",
    over="pi1",
    quantity="share of the link that is gone at the end of combing",
    measure=mean("expelled"),
    above=0.9,
)
