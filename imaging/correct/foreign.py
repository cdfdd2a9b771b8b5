"""Corrections from other programs: ImageJ's regions of interest, and label pictures."""

from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
from scipy.spatial import Delaunay, QhullError
from skimage.morphology import skeletonize

from imaging.correct.schema import Corrections, Only, Photograph, parse_corrections
from imaging.errors import Unmeasurable
from imaging.photo.decode import decode

CORNER = 0.5  # px; ImageJ counts from the corner of the first pixel
KEPT = 0.3  # px by which a line may be off when points are left out of it
ROI = (".zip", ".roi")
FORMS = "JSON of `combing edit`, ImageJ's .zip or .roi, or a picture of labels (0 = ground)"


def read_corrections(path: str | Path) -> Corrections:
    """Read corrections: JSON, ImageJ's ``.zip`` or ``.roi``, or a picture of labels.

    Lines of ImageJ, and the strands of labels, are all the strands there are: what was measured
    along one is kept, what is missing is drawn, what lies elsewhere is taken away.

    Raises
    ------
    Unmeasurable
        When the file is none of these or holds no line.
    """
    path = Path(path)
    if not path.is_file():
        raise Unmeasurable(f"{path}: no such file; corrections are {FORMS}")
    if path.suffix.lower() == ".json":
        return parse_corrections(_text(path), str(path))
    if path.suffix.lower() in ROI:
        return Corrections(steps=[Only(lines=_roi_lines(path))])
    stored = decode(path).pixels
    labels = stored if stored.ndim == 2 else stored[..., 0]
    if stored.ndim == 3 and (stored[..., :3] != stored[..., :1]).any():
        raise Unmeasurable(f"{path}: a coloured picture; corrections are {FORMS}")
    height, width = labels.shape
    return Corrections(
        photograph=Photograph(name=path.name, width=width, height=height),
        steps=[Only(lines=_label_lines(labels, path))],
    )


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise Unmeasurable(f"{path}: no text in UTF-8; corrections are {FORMS}") from None


def _roi_lines(path: Path) -> list[list[tuple[float, float]]]:
    """Lines of ImageJ's file; not its points and the outlines of contact."""
    try:
        import roifile
    except ImportError:
        raise Unmeasurable(
            f"{path}: ImageJ files need the extra: pip install 'combing[formats]'"
        ) from None
    try:
        found = roifile.roiread(path)
    except Exception as error:  # the package raises whatever its parsing meets
        raise Unmeasurable(f"{path}: not a file of ImageJ's ROI manager ({error})") from None
    kinds = {roifile.ROI_TYPE[name] for name in ("FREELINE", "POLYLINE", "LINE")}
    rois = found if isinstance(found, list) else [found]
    lines = [
        _plain(np.asarray(roi.coordinates(), float) - CORNER)
        for roi in rois
        if roi.roitype in kinds and not roi.name.startswith("unresolved-")
    ]
    if not lines:
        raise Unmeasurable(
            f"{path}: holds no line (segmented, straight or freehand); a strand is one"
        )
    return lines


def _label_lines(labels: np.ndarray, path: Path) -> list[list[tuple[float, float]]]:
    """Middle line of each label's pixels; parts that are hidden are bridged."""
    numbers = np.unique(labels[labels > 0])
    if not len(numbers) or len(numbers) > 255:
        raise Unmeasurable(f"{path}: holds {len(numbers)} labels; corrections are {FORMS}")
    lines = [_middle(labels == number) for number in numbers]
    return [_plain(line) for line in lines if len(line) > 2]


def _middle(mask: np.ndarray) -> np.ndarray:
    """Longest way (n, 2) through the shortest tree that spans a mask's skeleton."""
    ys, xs = np.nonzero(skeletonize(mask))
    points = np.stack([xs, ys], axis=1).astype(float)
    try:
        corners = Delaunay(points).simplices
        a, b = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]).T
    except (QhullError, ValueError):  # on one straight line
        order = np.lexsort(points.T)
        a, b = order[:-1], order[1:]
    far = np.hypot(*(points[a] - points[b]).T)
    graph = coo_array((far, (a, b)), shape=(len(points), len(points))).tocsr()
    tree = minimum_spanning_tree(graph.minimum(graph.T) + _one_way(graph))
    last = _farthest(tree, 0, points)[0]
    other, before = _farthest(tree, last, points)
    way = [other]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return points[way]


def _one_way(graph: coo_array) -> coo_array:
    """Edges that are given in one direction only."""
    return graph - graph.minimum(graph.T)


def _farthest(tree: coo_array, start: int, points: np.ndarray) -> tuple[int, np.ndarray]:
    """Farthest point along a tree, and from where each point is reached."""
    order, before = breadth_first_order(tree, start, directed=False)
    far = np.zeros(len(points))
    for point in order[1:]:
        far[point] = far[before[point]] + np.hypot(*(points[point] - points[before[point]]))
    return int(far.argmax()), np.where(before < 0, -1, before)


def _plain(line: np.ndarray) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in line]
