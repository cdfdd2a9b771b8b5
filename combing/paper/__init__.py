"""The paper's force curves, costs and claims by one command, from a study that a lab can edit."""

from combing.paper.make import make_paper

__all__ = ["make_paper"]
