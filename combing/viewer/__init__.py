"""A page on which runs move: strands in space, force and link density under one scrubber."""

from combing.viewer.page import run_page
from combing.viewer.shots import LIMIT, Shown, shown

__all__ = ["LIMIT", "Shown", "run_page", "shown"]
