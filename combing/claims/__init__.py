"""What the paper claims, claim by claim, held against a study: one small module each.

A module holds a `CLAIM`: the sentence in our words, where the paper says it, the quantity that
decides, and the threshold, stated before anything is measured.
"""

from combing.claims.claim import Claim, Finding, Verdict
from combing.claims.judge import all_claims, judge

__all__ = ["Claim", "Finding", "Verdict", "all_claims", "judge"]
