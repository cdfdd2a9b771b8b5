"""The step stays the same late in the stroke."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="Towards the free end the step of link density reaches a plateau.",
    where="text after Fig. 2",
    over="pi1",
    quantity="relative change of the jump from x of 0.5 to 0.7 to x of 0.75 to 0.95",
    measure=mean("jump_change"),
    above=-0.2,
    below=0.2,
)
