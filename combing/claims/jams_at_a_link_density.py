"""The tine jams where the link density ahead of it is high."""

from combing.claims.claim import Claim
from combing.claims.measures import mean

CLAIM = Claim(
    sentence="The tine jams when the link density ahead of it passes a threshold.",
    where="text after Fig. 3",
    over="pi1",
    quantity="share of the stroke with a lower link density, two pitches ahead, than at the jams",
    measure=mean("below_jams"),
    above=0.8,
)
