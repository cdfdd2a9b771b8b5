"""The bench where photographs, force logs and simulations meet on the same axes."""

__version__ = "0.1.0"
