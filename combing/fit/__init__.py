"""Friction and bending rigidity from a lab's own logs and photographs, by an emulator over runs."""

from combing.fit.emulator import Emulator, train
from combing.fit.make import Fit, make_fit
from combing.fit.plan import FitPlan, load_fit
from combing.fit.posterior import Posterior, posterior

__all__ = [
    "Emulator",
    "Fit",
    "FitPlan",
    "Posterior",
    "load_fit",
    "make_fit",
    "posterior",
    "train",
]
