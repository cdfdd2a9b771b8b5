"""One page over one run or several, to look at in a browser: nothing is fetched."""

import base64
import json
from collections.abc import Sequence
from pathlib import Path

import jinja2
import matplotlib as mpl
import numpy as np
from markupsafe import Markup

from combing.viewer.shots import Shown

SCRIPTS = ("three/three.min.js", "unpack.js", "space.js", "panel.js", "page.js")
MAPS = {"link": "RdYlBu_r", "bend": "viridis"}


def run_page(runs: Sequence[Shown]) -> str:
    """Return the page as HTML.

    Parameters
    ----------
    runs : sequence of Shown
        From `shown`; side by side, moved by one scrubber.
    """
    folder = Path(__file__).parent
    room = jinja2.Environment(loader=jinja2.FileSystemLoader(folder), autoescape=True)
    data = {
        "runs": [run.data for run in runs],
        "maps": {key: _map(name) for key, name in MAPS.items()},
    }
    packed = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    script = "\n".join((folder / name).read_text(encoding="utf-8") for name in SCRIPTS)
    return room.get_template("page.html").render(
        title=", ".join(dict.fromkeys(run.data["title"] for run in runs)),
        style=Markup((folder / "page.css").read_text(encoding="utf-8")),
        data=Markup(packed),
        script=Markup(script),
    )


def _map(name: str) -> str:
    """Return 256 colours of one of matplotlib's maps, three bytes each."""
    colours = mpl.colormaps[name](np.linspace(0, 1, 256))[:, :3]
    return base64.b64encode(np.rint(255 * colours).astype("u1").tobytes()).decode()
