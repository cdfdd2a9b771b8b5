"""The first jam of a combed double helix at P/r = 24, and what comes after it."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

import sim
from combing.accuracy.measurement import Measurement
from combing.bands.release import first_jam
from instron.scaling.average import profile
from sim.march.state import rigidities
from sim.scene import Contact, Scene
from sim.scene.presets import NYLON_SCALED

PI1, R = 24.0, 4.25e-4  # pitch over filament radius, filament radius [m]
L0 = 0.01  # m, in f = l0^2 F/B
WINDOW = PI1 * R / 6  # m; a whole number of elements on every mesh used, each of which ripples once
FLOOR = 2.0  # f that a jam exceeds


@dataclass(frozen=True)
class Jam:
    """Double helix of the preset, combed until the tine has come as far as `reach` [m].

    `elements` per pitch, tine `speed` [m/s], contact `stiffness` as a fraction of E.
    """

    elements: float = 12.0
    safety: float = 0.95
    speed: float = 0.2
    stiffness: float = 0.3
    reach: float = 0.021
    height: float = 0.1  # the first jam is that of 0.15 m
    imperfection: float = 0.0
    seed: int = 0

    def scene(self) -> Scene:
        """Return the scene: the preset's, cut short while the tine still moves at full speed."""
        whole = sim.double_helix(
            pi1=PI1,
            r=R,
            height=self.height,
            elements_per_pitch=self.elements,
            speed=self.speed,
            imperfection=self.imperfection,
            seed=self.seed,
            snapshots=2,
        )
        tine = whole.tines[0]
        change = {
            "duration": tine.insertion + 0.5 * tine.ramp_at(self.speed) + self.reach / self.speed,
            "safety": self.safety,
            "contact": Contact(stiffness=self.stiffness * NYLON_SCALED),
        }
        return whole.model_copy(update=change)

    def measure(self) -> Measurement:
        """Return the height f of the first jam and its place d, and the whole curve."""
        scene = self.scene()
        began = time.process_time()
        run = sim.simulate(scene)
        seconds = time.process_time() - began
        log = run.force_log()
        bend, _ = rigidities(scene.rods[0].material, scene.rods[0].radius)
        d, f = smoothed(log["displacement"].to_numpy(), L0**2 / bend * log["force"].to_numpy())
        place, height = first_jam(d, f, FLOOR)
        return Measurement(
            quantity=height,
            place=place,
            steps=int(run.data.attrs["steps"]),
            seconds=seconds,
            d=d.tolist(),
            f=f.tolist(),
        )


def smoothed(d: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return f averaged as for every curve, over WINDOW, and the place where each length ends.

    The highest average before a release ends where the jam lets go.
    """
    source = profile(d, f)
    middle = source.places(WINDOW)
    return middle + WINDOW / 2, source.mean(middle, WINDOW)
