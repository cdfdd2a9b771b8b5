"""How a photograph is looked at: scale, region, mask; the same for commands and studies."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import imaging
from combing.errors import UserError
from imaging.correct import Corrections, told_besides
from imaging.helix import helix
from imaging.helix.measurement import HelixMeasurement
from imaging.measure import corrections_for
from imaging.photo import Photo
from imaging.photo.region import Box, parse_region
from imaging.scale import METRES, Request, Scale, calibrate, parse_scale


@dataclass(frozen=True)
class View:
    """What of a photograph is looked at, and how large its pixels are.

    Attributes
    ----------
    scale : Request, optional
        From `imaging.scale.parse_scale`; lengths are in pixels where there is none.
    roi : (x0, y0, x1, y1) or Path, optional
        Region of interest: a box in pixels, or a mask picture, white = look here.
    ignore : Path, optional
        Mask picture; white is ignored.
    """

    scale: Request | None = None
    roi: Box | Path | None = None
    ignore: Path | None = None

    @classmethod
    def asked(cls, scale: str | None, roi: str | None, ignore: str | Path | None) -> "View":
        """Understand scale and region in the words of the command line.

        Raises
        ------
        imaging.Unmeasurable
            If they are not understood.
        """
        return cls(
            parse_scale(scale) if scale else None,
            parse_region(roi) if roi else None,
            Path(ignore) if ignore else None,
        )

    def read(self, path: Path, page: int | None = None) -> Photo:
        """Read a photograph, or a page of a TIFF of several.

        Raises
        ------
        imaging.Unmeasurable
            If it is not a photograph, or region or mask do not fit it.
        """
        return imaging.read_photo(path, roi=self.roi, ignore=self.ignore, page=page)


def metres(text: str) -> float:
    """Read a length: a bare number of metres, or one with its unit, as 10mm; raise ValueError."""
    number = text.strip().rstrip("".join(set("".join(METRES))))
    unit = text.strip()[len(number) :].strip()
    if unit and unit not in METRES:
        raise ValueError(f"{text!r}: its unit is none of {', '.join(METRES)}")
    return float(number) * METRES[unit or "m"]


def measure_pair(
    path: Path,
    view: View,
    *,
    root: str = "top",
    pair: int = 1,
    tine: tuple[float, ...] | None = None,
) -> tuple[Photo, HelixMeasurement]:
    """Read a photograph and measure two strands in it that wind round each other.

    Parameters
    ----------
    path : Path
        The photograph.
    view : View
    root, tine
        As `imaging.helix.helix` takes them.
    pair : int
        Which of several pairs, counted from 1 from the one of the most turns.

    Raises
    ------
    UserError
        If it cannot be measured; the message names the file.
    """
    photo = view.read(path)
    ask = partial(helix, pair=pair - 1, root=root, tine=tine)
    try:
        scale, photo = calibrate(photo, view.scale)
        found = ask(photo, scale=scale)
        if view.scale is not None and view.scale.kind == "filament":
            # The strands' fitted width is the known length.
            known = _from_width(found, view.scale.numbers[0])
            found = ask(photo, scale=known.with_doubt(view.scale.length_sd))
    except imaging.Unmeasurable as error:
        text = str(error)
        raise UserError(text if str(path) in text else f"{path}: {text}") from error
    return photo, found


def _from_width(found: HelixMeasurement, diameter: float) -> Scale:
    # The half-contrast edge of a shaded tube lies within a few per cent of its outline.
    return Scale(diameter / (2 * found.r), 0.03, "filament diameter")


def said_of(
    photo: Photo,
    file: Path | str | None,
    source: str,
    *,
    strands: int | None = None,
    colours: Sequence[str] | None = None,
) -> Corrections:
    """Put together what a file of corrections and `source` say of a photograph.

    Parameters
    ----------
    photo : Photo
    file : path or None
        Of corrections; `imaging.measure.BESIDE` for the one beside the photograph.
    source : str
        Who says the rest, for messages: "the command line", a set of a study.
    strands : int, optional
        How many strands there are.
    colours : sequence of str, optional
        Their colours, #rrggbb; others are left out.
    """
    more = {"strands": strands, "colours": colours and [one.strip() for one in colours]}
    given = {key: value for key, value in more.items() if value is not None}
    return told_besides(corrections_for(photo, file), given, source)
