"""Photograph -> which strand colour each pixel shows, over which ground."""

from imaging.segment.segmentation import Segmentation, segment

__all__ = ["Segmentation", "segment"]
