"""Photograph -> which strand colour each pixel shows, over which ground."""

from imaging.segment.photograph import segment
from imaging.segment.segmentation import Segmentation

__all__ = ["Segmentation", "segment"]
