"""No jam at P/r = 48."""

from combing.claims.claim import Claim
from combing.claims.measures import share

CLAIM = Claim(
    sentence="In loose helices, P/r of 48, the tine never jams.",
    where="text after Fig. 3",
    over="pi1",
    quantity="share of curves with a jam that is released at once, P/r >= 48",
    measure=share("jams", lambda value: value >= 48),
    below=0.5,
)
