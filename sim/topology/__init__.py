"""Topology of strands in space: of a pair along its length, of any number by pair and in space."""

from sim.topology.pair import (
    average_crossing_number,
    box_average,
    common_arclength,
    corner_angles,
    curve_of,
    extended,
    gauss_link,
    link_density,
    net_axis,
    partners,
    twist,
    writhe,
)

__all__ = [
    "average_crossing_number",
    "box_average",
    "common_arclength",
    "corner_angles",
    "curve_of",
    "extended",
    "gauss_link",
    "link_density",
    "net_axis",
    "partners",
    "twist",
    "writhe",
]
