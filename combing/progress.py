"""Progress of long work on stderr."""

from typing import Any

from tqdm import tqdm

TOLD = 0.03  # of the work: a rate over less, compiling and starting included, tells nothing


class Bar(tqdm):
    """A bar in percent with the time gone and, as soon as the work tells it, the time left."""

    def __init__(self, **options: Any) -> None:
        super().__init__(
            bar_format="{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}",
            smoothing=0,  # the rate of all work, not of the latest: scenes end in lumps
            **options,
        )

    @property
    def format_dict(self) -> dict[str, Any]:
        """What is written: without a time left at first."""
        found = dict(super().format_dict)
        if found["n"] - found["initial"] < TOLD * found["total"]:
            found["bar_format"] = found["bar_format"].replace("<{remaining}", "")
        return found
