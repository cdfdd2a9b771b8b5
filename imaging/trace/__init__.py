"""Segmentation -> strands: sub-pixel centrelines through crossings."""

from imaging.trace.strands import Strand, trace

__all__ = ["Strand", "trace"]
