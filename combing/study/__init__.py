"""The study file: which photographs, force logs and scenes are compared, and how.

A study is a TOML file; paths in it are relative to it and may hold ``*``. See ``docs/study.md``.
"""

from combing.study.errors import StudyError
from combing.study.load import load_study
from combing.study.positions import tine_positions
from combing.study.sets import AnySet, CurlSet, ForceSet, LinkSet, Study

__all__ = [
    "AnySet",
    "CurlSet",
    "ForceSet",
    "LinkSet",
    "Study",
    "StudyError",
    "load_study",
    "tine_positions",
]
