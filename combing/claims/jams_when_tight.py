"""Rise, jam and drop below P/r of about 20."""

from combing.claims.claim import Claim
from combing.claims.measures import share

CLAIM = Claim(
    sentence="In tight helices, P/r below 20, the tine jams and breaks through.",
    where="text after Fig. 3",
    over="pi1",
    quantity="share of curves with a jam that is released at once, P/r < 20",
    measure=share("jams", lambda value: value < 20),
    above=0.5,
)
