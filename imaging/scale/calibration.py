"""Find the scale that was asked for, in the photograph or in one of the board."""

from imaging.errors import Unmeasurable
from imaging.photo import Photo, read_photo
from imaging.scale.board import from_charuco, from_grid
from imaging.scale.marker import from_marker, without_markers
from imaging.scale.request import Request
from imaging.scale.scale import Scale, from_ruler, stated


def calibrate(photo: Photo, request: Request | None) -> tuple[Scale | None, Photo]:
    """Find the scale of a photograph.

    Parameters
    ----------
    photo : Photo
    request : Request or None
        From `imaging.scale.parse_scale`. None, or a filament's diameter (which needs the strands:
        `imaging.scale.from_filament`), gives no scale.

    Returns
    -------
    scale : Scale or None
    photo : Photo
        The same with markers and board to be ignored.

    Raises
    ------
    Unmeasurable
        When the marker or board is not found, or not as it should be.
    """
    if request is None or request.kind == "filament":
        return None, without_markers(photo)
    if request.kind == "stated":
        scale = stated(*request.numbers)
    elif request.kind == "ruler":
        x0, y0, x1, y1, length = request.numbers
        scale = from_ruler((x0, y0), (x1, y1), length)
    elif request.board is not None:
        scale = _on_board(_board_photo(photo, request.board), request)[0]
    else:
        scale, photo = _on_board(photo, request)
        if request.kind in ("marker", "plane"):
            return scale.with_doubt(request.length_sd), photo
    return scale.with_doubt(request.length_sd), without_markers(photo)


def _on_board(photo: Photo, request: Request) -> tuple[Scale, Photo]:
    if request.kind in ("marker", "plane"):
        return from_marker(photo, *request.numbers, perspective=request.kind == "plane")
    columns, rows, side, other = request.numbers
    find = from_charuco if request.kind == "charuco" else from_grid
    return find(photo, (int(columns), int(rows)), side, other)


def _board_photo(photo: Photo, path: str) -> Photo:
    board = read_photo(path)
    if board.shape != photo.shape:
        raise Unmeasurable(
            f"{path}: the board's photograph is {board.shape[1]} x {board.shape[0]} pixels, "
            f"{photo.source} {photo.shape[1]} x {photo.shape[0]}; take both with the same camera, "
            "from the same place, at the same zoom"
        )
    return board
