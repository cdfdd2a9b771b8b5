"""Drawn photographs of known truth, and how far a measurement lies from it."""
