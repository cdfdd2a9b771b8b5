"""The knobs that buy accuracy, and a scene with them turned."""

from dataclasses import asdict, dataclass

import sim
from combing.errors import UserError
from sim.explicit import Explicit
from sim.scene import Contact, Helix, Tine


@dataclass(frozen=True)
class Setting:
    """What accuracy costs time by: all else of a scene is what is simulated.

    Attributes
    ----------
    elements : float
        To a pitch.
    safety : float
        Step over the stable one.
    speed : float
        Of the tine [m/s]; slower is nearer to a tine that moves infinitely slowly.
    stiffness : float
        Of contact, over Young's modulus; stiffer is nearer to hard strands.
    """

    elements: float
    safety: float
    speed: float
    stiffness: float

    def scaled(self, factor: float) -> "Setting":
        """Return the setting whose every error is `factor` times as large.

        Errors go as the square of an element, as the speed and as one over the stiffness.
        """
        return Setting(
            self.elements / factor**0.5, self.safety, self.speed * factor, self.stiffness / factor
        )

    def __str__(self) -> str:
        """Return it in words."""
        return (
            f"{self.elements:.3g} elements a pitch, {self.safety:g} of the stable step, tine at "
            f"{self.speed:.3g} m/s, contact {self.stiffness:.2g} E"
        )


def with_setting(scene: sim.Scene, setting: Setting) -> sim.Scene:
    """Return a combing of helices with its knobs turned; the places of its samples stay.

    Raises
    ------
    UserError
        It is no combing of helices by one tine, which the front has been measured for.
    """
    tine, helices = _combed(scene)
    moved = tine.model_copy(update={"speed": setting.speed})
    softest = min(rod.material.E for rod in scene.rods)
    rate = scene.output.sample_rate * setting.speed / tine.speed
    rods = [
        rod.model_copy(update={"elements": max(4, round(setting.elements * h.height / h.pitch))})
        for rod, h in zip(scene.rods, helices, strict=True)
    ]
    contact = scene.contact or Contact()
    return scene.model_copy(
        update={
            "rods": rods,
            "tines": [moved],
            "duration": scene.duration - tine.duration + moved.duration,
            "contact": contact.model_copy(update={"stiffness": setting.stiffness * softest}),
            "safety": setting.safety,
            "time_step": None,
            "output": scene.output.model_copy(update={"sample_rate": rate}),
        }
    )


def _combed(scene: sim.Scene) -> tuple[Tine, list[Helix]]:
    helices = [rod.shape for rod in scene.rods if isinstance(rod.shape, Helix)]
    if len(helices) < len(scene.rods) or len(scene.tines) != 1 or not scene.tines[0].travel:
        raise UserError(
            f"{scene.title}: a tolerance is for helices that one tine combs, which the front of "
            "accuracy was measured for; choose elements by hand, and see what they do: --error-bars"
        )
    return scene.tines[0], helices


def work(scene: sim.Scene) -> float:
    """Return steps times elements, which a run's time goes as."""
    march = Explicit(scene)
    return scene.duration / march.dt * sum(march.state.elements)


def as_row(setting: Setting) -> dict[str, float]:
    """Return a setting as a row of a table."""
    return asdict(setting)
