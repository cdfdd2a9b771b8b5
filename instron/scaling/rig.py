"""The rig and specimen a force log was measured with: a small TOML file, checked."""

import math
import tomllib
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, ValidationError, model_validator

from instron.errors import RigError

NYLON = 3 * 4.25e-4  # m; 3 r of the study's filament
MILLIMETRES = "is it in mm? write metres"
RANGES = {
    "r": (1e-7, 1e-2, "m", MILLIMETRES),
    "E": (1e4, 2e12, "Pa", "is it in GPa or MPa? write pascals"),
    "B": (1e-18, 1e3, "N m^2", "it is that of one filament, in N m^2"),
    "l0": (1e-6, 1.0, "m", MILLIMETRES),
    "average_over": (1e-7, 0.1, "m", MILLIMETRES),
    "pitch": (1e-6, 1.0, "m", MILLIMETRES),
    "helix_radius": (1e-7, 0.1, "m", MILLIMETRES),
    "compliance": (0.0, 0.01, "m/N", "is it in mm/N? write m/N"),
}


class Rig(BaseModel):
    """What is needed to turn F(d) into f(x). SI units.

    Attributes
    ----------
    B, r, E
        Bending rigidity of one filament [N m^2], or its radius [m] and Young's modulus [Pa] from
        which ``B = pi E r^4 / 4`` follows.
    poisson
        Poisson's ratio, for the twisting rigidity ``C = B / (1 + poisson)``.
    l0
        Length of the scaling ``f = l0^2 F / B`` [m].
    average_over
        Length along d over which F is averaged before its highest value, the end of combing, noise
        and events are read off [m]; 3 r if left out (NYLON where r is not given either).
    pitch, helix_radius, turns
        Shape of the helix [m, m, number]; only Love's curve needs it.
    zero
        Rule for the force zero: ``free`` (the quiet end after combing), ``start`` (the first
        rows), ``drift`` (a line through both), ``none``, or ``auto``: drift if the slope of the end
        explains by how much start and end differ, free if the end is quiet, else none.
    end_fraction, end_sigma
        Rule for D: combing ends where the force falls for good through ``end_fraction`` of its
        peak; what is below ``end_sigma`` times the noise of the averaged force is none.
    compliance
        Of machine and grips [m/N]; ``compliance * F`` is taken off the displacement.
    toe
        Offset of the displacement: ``none``, or ``tangent`` (where the tangent at the foot of
        the first rise meets zero; off by default: gentle combing may be taken for slack).
    force_sign
        +1 or -1: the sign in the file of a force that resists combing; 0 finds out.
    u_r, u_E
        Relative standard uncertainties of r and E, if stated.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    r: PositiveFloat | None = None
    E: PositiveFloat | None = None
    B: PositiveFloat | None = None
    poisson: float = Field(0.5, gt=-1, le=0.5)
    l0: PositiveFloat = 0.01
    average_over: PositiveFloat | None = None
    pitch: PositiveFloat | None = None
    helix_radius: PositiveFloat | None = None
    turns: PositiveFloat | None = None
    zero: Literal["auto", "free", "start", "drift", "none"] = "auto"
    end_fraction: float = Field(0.02, ge=0, lt=1)
    end_sigma: float = Field(5.0, ge=0)
    compliance: float = Field(0.0, ge=0)
    toe: Literal["none", "tangent"] = "none"
    force_sign: Literal[-1, 0, 1] = 0
    u_r: float | None = Field(None, ge=0, lt=1)
    u_E: float | None = Field(None, ge=0, lt=1)
    notes: str = ""

    @model_validator(mode="after")
    def _sizes_are_possible(self) -> "Rig":
        for key, (low, high, unit, hint) in RANGES.items():
            value = getattr(self, key)
            if value is not None and not low <= value <= high:
                raise ValueError(
                    f"{key} = {value:g} {unit} is out of range ({low:g} to {high:g}): {hint}"
                )
        return self

    @model_validator(mode="after")
    def _rigidity_is_known(self) -> "Rig":
        if self.B is None and (self.r is None or self.E is None):
            raise ValueError("give B, or both r and E")
        if self.B is not None and self.E is not None:
            raise ValueError("give either B or E, not both")
        return self

    @property
    def rigidity(self) -> float:
        """Bending rigidity B of one filament [N m^2]."""
        if self.B is not None:
            return self.B
        assert self.r is not None and self.E is not None  # noqa: S101, PT018 (validated above)
        return math.pi / 4 * self.E * self.r**4

    @property
    def averaging_length(self) -> float:
        """Length along d over which F is averaged [m]."""
        return self.average_over or (3 * self.r if self.r else NYLON)

    @property
    def twisting(self) -> float:
        """Twisting rigidity C of one filament, B / (1 + poisson) [N m^2]."""
        return self.rigidity / (1 + self.poisson)

    @property
    def relative_uncertainty(self) -> float:
        """Relative standard uncertainty of B, and so of f: r counts four times; NaN: not stated."""
        if self.u_r is None and self.u_E is None:
            return math.nan
        return math.hypot(self.u_E or 0.0, 4 * (self.u_r or 0.0))


def load_rig(path: str | Path) -> Rig:
    """Read a rig from a TOML file: all of it, or its table ``[rig]`` where it has one.

    Raises
    ------
    RigError
        With file, key, the value found and what would be right.
    """
    path = Path(path)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise RigError(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise RigError(f"{path}: not valid TOML: {error}") from None
    try:
        return Rig(**table.get("rig", table))
    except ValidationError as error:
        raise RigError(f"{path}: {_sentence(error)}") from None


def _sentence(error: ValidationError) -> str:
    """Return the first complaint as one line."""
    first = error.errors()[0]
    key = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        return f"unknown key '{key}'; known are {', '.join(Rig.model_fields)}"
    if not key:
        return first["msg"].removeprefix("Value error, ")
    return f"{key} = {first['input']!r}: {first['msg'].lower()}"
