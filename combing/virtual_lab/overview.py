"""One figure of the data set: a photograph of each kind and all force logs."""

from pathlib import Path

from matplotlib.figure import Figure

import instron
from combing.figures.photographs import smaller
from combing.figures.style import WIDTH, mark_synthetic, paper_style

SHORTER = 700  # px; height of the photographs in the figure


def draw_overview(out: Path) -> None:
    """Draw ``synthetic_overview.png`` from the files of the data set in `out`."""
    helices = sorted((out / "photos").glob("synthetic_helix_[1-9].jpg"))
    curls = sorted((out / "photos").glob("synthetic_curl_*.jpg"))
    photos = [out / "photos" / "synthetic_helix_before.jpg", helices[len(helices) // 2], curls[0]]
    pictures = [smaller(path, SHORTER) for path in photos]
    widths = [max(picture.shape[1] / SHORTER, 0.25) for picture in pictures]
    with paper_style():
        figure = Figure(figsize=(WIDTH, 3.0), layout="constrained")
        panels = figure.subplots(1, 4, width_ratios=[*widths, 1.2])
        for panel, picture, path in zip(panels, pictures, photos, strict=False):
            panel.imshow(picture)
            panel.set_axis_off()
            panel.set_title(path.stem.removeprefix("synthetic_").replace("_", " "))
        for path in sorted((out / "logs").glob("*.csv")):
            (log,) = instron.read(path)
            panels[3].plot(log["displacement"] * 1e3, log["force"], lw=0.7)
        panels[3].set(xlabel="displacement (mm)", ylabel="force (N)", title="logs")
        mark_synthetic(figure, True)
        partial = out / ".synthetic_overview.png"
        figure.savefig(partial, metadata={"Description": "synthetic data (virtual lab)"})
        partial.replace(out / "synthetic_overview.png")
