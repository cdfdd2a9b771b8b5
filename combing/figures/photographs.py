"""The photographs that were measured, side by side and scaled down."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image, ImageOps

from combing.figures.style import mark_synthetic, new_figure, paper_style

HEIGHT = 420  # px of a photograph in the figure
COLUMNS = 5


def draw_photographs(photos: Mapping[str, Path], *, synthetic: bool) -> Figure:
    """Draw every photograph under its title, all at the same height.

    Parameters
    ----------
    photos : mapping
        Paths by title.
    synthetic : bool
        Whether the photographs come from the virtual lab.
    """
    with paper_style():
        rows = -(-len(photos) // COLUMNS)
        figure, panels = new_figure(rows, min(COLUMNS, len(photos)), 1.9)
        for panel, (title, path) in zip(panels, photos.items(), strict=False):
            panel.imshow(smaller(path, HEIGHT))
            panel.set_title(title, fontsize=8)
        for panel in panels:
            panel.set_axis_off()
        mark_synthetic(figure, synthetic)
    return figure


def smaller(path: Path, height: int) -> np.ndarray:
    """Read a photograph upright and scale it down to `height` pixels (h, w, 3).

    One that cannot be read, which the report names with its reason, is shown as a grey field.
    """
    try:
        with Image.open(path) as photo:
            upright = ImageOps.exif_transpose(photo).convert("RGB")
    except (OSError, SyntaxError):
        return np.full((height, height, 3), 200, np.uint8)
    width = max(round(upright.width * height / upright.height), 1)
    return np.asarray(upright.resize((width, height), Image.Resampling.BOX))
