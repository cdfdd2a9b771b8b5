"""One figure a module, each drawn from a tidy table and nothing else."""
