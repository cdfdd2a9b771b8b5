"""The study file: which photographs, force logs and scenes are compared, and how.

A study is a TOML file; paths in it are relative to it and may hold ``*``. See ``docs/study.md``.
"""

from combing.study.errors import StudyError
from combing.study.load import load_study, load_sweep
from combing.study.plan import Sweep
from combing.study.positions import combed, tine_positions
from combing.study.sets import CurlSet, ForceSet, LinkSet
from combing.study.study import AnySet, Study
from combing.study.sweeps import SweepSet

__all__ = [
    "AnySet",
    "CurlSet",
    "ForceSet",
    "LinkSet",
    "Study",
    "StudyError",
    "Sweep",
    "SweepSet",
    "combed",
    "load_study",
    "load_sweep",
    "tine_positions",
]
