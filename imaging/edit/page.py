"""One page over a photograph and its measurement, to correct it by hand in a browser.

Everything is in the file: no server, nothing fetched. What the hand says is saved as corrections
(`imaging.correct`), which this program applies; the page only shows what to expect of them.
"""

import base64
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import jinja2
import numpy as np
import pandas as pd
from markupsafe import Markup

from imaging.correct import Corrections
from imaging.edit.wire import wire_cost
from imaging.measure import Measured
from imaging.photo import Photo
from imaging.report.overlay import as_jpeg, few_points
from imaging.trace.centreline import arclength

SCRIPTS = ("geometry.js", "steps.js", "wire.js", "page.js")
OFF = 0.25  # px by which a shown line may be off
GUESS = 1 / 90  # of the picture's shorter side: a strand's width where none was measured


@dataclass(frozen=True)
class Place:
    """Where a page stands among those of a folder.

    Attributes
    ----------
    previous, next : str
        File names of the pages before and after; empty = none.
    told : str
        Such as ``2 of 5``.
    """

    previous: str = ""
    next: str = ""
    told: str = ""


def edit_page(
    photo: Photo,
    measured: Measured | None,
    corrections: Corrections,
    *,
    refused: str = "",
    place: Place = Place(),  # noqa: B008 - frozen
) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    photo : Photo
    measured : Measured or None
        Its measurement without corrections; None where it could not be measured.
    corrections : Corrections
        What was said of it before; the page goes on from there.
    refused : str
        Why it could not be measured.
    place : Place
        Links to the other pages of a folder.
    """
    folder = Path(__file__).parent
    room = jinja2.Environment(loader=jinja2.FileSystemLoader(folder), autoescape=True)
    data = json.dumps(_data(photo, measured, corrections, refused), allow_nan=False)
    script = "\n".join((folder / name).read_text(encoding="utf-8") for name in SCRIPTS)
    return room.get_template("page.html").render(
        name=Path(photo.source).name,
        style=Markup((folder / "page.css").read_text(encoding="utf-8")),
        data=Markup(data.replace("<", "\\u003c")),
        script=Markup(script),
        previous=place.previous,
        next=place.next,
        place=place.told,
    )


def _data(
    photo: Photo, measured: Measured | None, corrections: Corrections, refused: str
) -> dict[str, Any]:
    """Gather what the page needs, as plain values."""
    height, across = photo.shape
    width = min(height, across) * GUESS if measured is None else measured.segmentation.width
    cost, scale = wire_cost(photo, width)
    said = corrections.model_dump(mode="json", by_alias=True)
    found: dict[str, Any] = {"strands": [], "crossings": [], "contacts": [], "sections": 20}
    if measured is not None:
        found = _found(measured)
    return found | {
        "photograph": {"name": Path(photo.source).name, "width": across, "height": height},
        "picture": _url("jpeg", as_jpeg(photo.eight_bits())),
        "wire": {"picture": _url("png", cv2.imencode(".png", cost)[1].tobytes()), "scale": scale},
        "width": round(float(width), 2),
        "notes": ([refused] if refused else []) + ([] if measured is None else measured.notes),
        "corrections": {key: said[key] for key in ("ground", "colours", "strands", "steps")},
    }


def _found(measured: Measured) -> dict[str, Any]:
    """Strands, crossings and contacts, strands counted from 0."""
    table = measured.crossings
    crossings = [
        {
            "at": _rounded(np.array([row["x"], row["y"]])),
            "on": [int(row["strand_a"]) - 1, int(row["strand_b"]) - 1],
            "over": None if pd.isna(row["over"]) else int(row["over"]) - 1,
        }
        for row in table[table["kind"] == "inter"].to_dict("records")
    ]
    strands = [
        {
            "line": _rounded(few_points(strand.line, OFF)),
            "width": round(float(np.median(strand.width)), 2),
        }
        for strand in measured.strands
    ]
    contacts = []
    for row in measured.unresolved.to_dict("records"):
        line = measured.strands[row["strand_a"] - 1].line
        s = arclength(line)
        contacts.append(
            _rounded(few_points(line[(s >= row["s_a_from"]) & (s <= row["s_a_to"])], OFF))
        )
    sections = 20 if measured.interactions is None else measured.interactions.attrs["n_sec"]
    return {"strands": strands, "crossings": crossings, "contacts": contacts, "sections": sections}


def _shown(line: np.ndarray) -> list:
    """Return a line as the page draws it."""
    return _rounded(few_points(line, OFF))


def _rounded(points: np.ndarray) -> list:
    return np.round(points.astype(float), 2).tolist()


def _url(kind: str, coded: bytes) -> str:
    return f"data:image/{kind};base64,{base64.b64encode(coded).decode()}"
