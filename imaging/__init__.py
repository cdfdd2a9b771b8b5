"""Photographs of coloured strands: crossings, N-body interactions, helix centreline, link density."""
