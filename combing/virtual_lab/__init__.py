"""A small synthetic data set that stands in for a lab's own, with its truth beside it."""
