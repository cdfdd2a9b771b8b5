"""One self-contained HTML page: figures inlined, no scripts, nothing fetched."""

import base64
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd


@dataclass(frozen=True)
class Section:
    """A heading with text, at most one figure, and tables.

    Attributes
    ----------
    title : str
        Heading.
    text : sequence of str
        Paragraphs.
    figure : Path, optional
        PNG to inline; an SVG of the same stem lies beside it.
    caption : str
        What the figure shows.
    data : str, optional
        Name of the CSV file with the plotted numbers.
    tables : sequence of (caption, DataFrame)
        Tables below the figure.
    notes : sequence of str
        What was left out or is doubtful.
    quote : str
        Text to copy as it stands.
    """

    title: str
    text: Sequence[str] = ()
    figure: Path | None = None
    caption: str = ""
    data: str | None = None
    tables: Sequence[tuple[str, pd.DataFrame]] = field(default_factory=list)
    notes: Sequence[str] = ()
    quote: str = ""


def write_report(
    path: Path,
    title: str,
    sections: Sequence[Section],
    *,
    about: str,
    footer: str,
    synthetic: bool,
    files: str = "",
) -> None:
    """Write the page.

    Parameters
    ----------
    path : Path
        HTML file to write.
    title, about, footer : str
        Heading, the line below it, and the last line.
    sections : sequence of Section
        What the page shows, in order.
    synthetic : bool
        Whether to say on top that the experiment comes from the virtual lab.
    files : str
        Folder of the figures' files, seen from the page, with a slash at its end.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("combing"), autoescape=True, trim_blocks=True
    )
    environment.filters.update(inline=_inline, width=_width, shown=shown)
    page = environment.get_template("report.html").render(
        title=title, sections=sections, about=about, footer=footer, synthetic=synthetic, files=files
    )
    path.write_text(page, encoding="utf-8")


def shown(value: Any, digits: int = 3) -> str:
    """Write a number with `digits` significant ones, a missing one as a dash.

    A whole one below 1000 is a count or a set value (nothing measured comes out whole): as such.
    """
    if value is pd.NA:
        return "–"
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "–"
    if value.is_integer() and abs(value) < 1e3:
        return f"{value:.0f}".replace("-", "−")
    if 1e-3 <= abs(value) < 1e5:
        places = digits - 1 - math.floor(math.log10(abs(value)))
        return f"{value:.{max(places, 0)}f}".replace("-", "−")
    return f"{value:.{digits - 1}e}".replace("-", "−")


def _width(png: Path) -> int:
    """Width on the page [px]: a little over the size in print, half the PNG's own pixels."""
    (pixels,) = struct.unpack(">I", png.read_bytes()[16:20])
    return pixels * 58 // 100


def _inline(png: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(png.read_bytes()).decode("ascii")
