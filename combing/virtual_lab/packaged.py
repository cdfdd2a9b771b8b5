"""Where the packaged data set is."""

from importlib import resources
from pathlib import Path

from combing.errors import UserError


def data_folder() -> Path:
    """Folder of the packaged data set: inside an installed package, beside an editable one."""
    package = Path(str(resources.files("combing")))
    for folder in (package / "data", package.parent / "data"):
        if (folder / "study.toml").is_file():
            return folder
    raise UserError(f"{package / 'data'}: the packaged data set is missing; install combing again")
