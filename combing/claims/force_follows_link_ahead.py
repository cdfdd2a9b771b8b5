"""The force follows the link density ahead of the tine while it moves."""

from combing.claims.claim import Claim
from combing.claims.measures import mean_correlation

CLAIM = Claim(
    sentence="The force follows magnitude and extent of the link density ahead of the tine.",
    where="abstract",
    over="pi1",
    quantity="rank correlation, over tine places, of the force and the turns in excess ahead",
    measure=mean_correlation("force_and_excess"),
    above=0.5,
)
