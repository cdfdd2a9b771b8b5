"""Texts that go with the data set: the rig, the study of the demo, and the README."""

from combing.virtual_lab.machine import NOISE
from combing.virtual_lab.photographs import MARKER_SIDE
from combing.virtual_lab.specimens import (
    CURLS,
    FRICTION,
    HAIR_RADIUS,
    HAIRS,
    HEIGHT,
    IMPERFECTION,
    PI1,
    PITCH_SCATTER,
    RADIUS,
    REPEATS,
    YOUNG,
)

RIG = f"""\
# The virtual lab's rig and specimen (synthetic). SI units.
r = {RADIUS}            # filament radius
E = {YOUNG:.6g}         # Young's modulus, nylon scaled by 0.078 as in the paper's simulations
poisson = 0.4
pitch = {PI1 * RADIUS:.6g}
helix_radius = {RADIUS}
turns = {HEIGHT / (PI1 * RADIUS):.4f}
notes = "synthetic: virtual lab"
"""

_FORCE = f"""\
# The demo's study: the virtual lab's specimens (synthetic) beside frictionless simulations.
# Copy it and name your own files; docs/study.md lists the keys.
title = "Combing a double helix: virtual lab and simulation"
n_sec = 20

[[force]]
name = "P/r = {PI1:g}, R/r = 1"
logs = "logs/synthetic_combing_*.csv"
rig = "rig.toml"
simulation = "scenes/double_helix.toml"
truth = "truth/synthetic_force.csv"
"""


def photographed(folder: str = "", helices: str = "[1-9]", curls: str = "*") -> str:
    """Return the sets of a study that are of the data set's photographs.

    Parameters
    ----------
    folder : str
        Where it is, seen from the study, with a slash at its end.
    helices, curls : str
        Patterns of the numbers of those that are taken.
    """
    return f"""
[[link]]
name = "P/r = {PI1:g}, R/r = 1"
photos = "{folder}photos/synthetic_helix_{helices}.jpg"
before = "{folder}photos/synthetic_helix_before.jpg"
positions = "{folder}photos/synthetic_helix_positions.csv"
marker_side = {MARKER_SIDE}
simulation = "{folder}scenes/double_helix.toml"
truth = "{folder}truth/synthetic_link.csv"

[[curl]]
name = "{HAIRS} hairs"
photos = "{folder}photos/synthetic_curl_{curls}.jpg"
marker_side = {MARKER_SIDE}
strands = {HAIRS}
simulations = "{folder}scenes/curl_{curls}.toml"
truth = "{folder}truth/synthetic_interactions.csv"
"""


STUDY = _FORCE + photographed()


def readme() -> str:
    """Return the README of the data set."""
    return f"""\
# Virtual lab: a synthetic data set

**Nothing here was measured.** Everything is made from simulations by `combing virtual-lab -o data`
and stands in for a lab's own files until there are some. File names begin with `synthetic_`,
photographs say so in their EXIF description, machine exports in their metadata lines, tables in
their first line, and every figure drawn from them says so in its corner.

![overview](synthetic_overview.png)

- `photos/synthetic_helix_before.jpg`, `synthetic_helix_1.jpg` ...: a combed double helix,
  P/r = {PI1:g}, R/r = 1, r = {RADIUS * 1e3:g} mm, h = {HEIGHT * 1e3:g} mm, before the tine is
  inserted and at several places of the tine (`synthetic_helix_positions.csv`); strands 16 px wide.
- `photos/synthetic_curl_1.jpg` ...: {CURLS} curls of {HAIRS} hairs, r = {HAIR_RADIUS * 1e3:g} mm,
  5 px wide, in {HAIRS} colours.
- `logs/synthetic_combing_1.csv` ...: {REPEATS} combings as Bluehill 3 exports them.
- `rig.toml`, `study.toml`, `scenes/`: the rig, the study of `combing demo`, and its simulations.
- `truth/`: what is true of the above: forces, link density along s, interactions, strands in
  space, and which versions made it.

**Photographs**: strands rendered as shaded tubes through a pinhole 0.7 m away (perspective), on a
dark cloth, with clamp and tine in matt black and an ArUco marker of {MARKER_SIDE * 1e3:g} mm in the
plane of the clamp; then uneven light, vignette, blur of 1 px, noise of 2 % (0.5 % in the dark),
JPEG. The pair ahead of the tine kinks and whirls: pictures are taken where the kink shows its
broad side.

**Logs**: each specimen has its own friction coefficient ({FRICTION[0]} to {FRICTION[1]}), pitch
(+-{PITCH_SCATTER:.0%}) and intrinsic curvature (sd {IMPERFECTION:.0%} of the helix's, seeded); the
load cell adds an offset, a drift and noise of {NOISE * 1e3:g} mN. Combing 1 is the one that was
photographed. Time is simulated time: the tine moves at 0.2 m/s, far faster than on the machine.

The specimens of the experiment have friction and imperfections, the simulations of the study have
neither: where the two differ, that is physics, not the error of a measurement. The error of every
measurement against the truth is in the report of `combing demo`.
"""
