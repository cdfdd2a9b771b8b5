"""The compiled part of ``sim``: formulas and hot loops, no validation and no exceptions."""
