"""The pages of a TIFF: which of them are photographs, and the pixels of those without a header."""

import struct
from pathlib import Path

import numpy as np
import tifffile

from imaging.errors import Unmeasurable

RAW_SUFFIXES = (".arw", ".cr2", ".cr3", ".dng", ".nef", ".orf", ".raf", ".rw2")
HEADS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")  # TIFF and BigTIFF, both byte orders
NO_PHOTOGRAPH = 0b101  # NewSubfileType: bit 0 a smaller copy, bit 2 a mask of another page
CHANNELS = "they are channels of one picture; save it as RGB (ImageJ: Image > Type > RGB Color)"


def pages_of(path: Path) -> tuple[int, ...]:
    """Return the numbers, from 1, of the pages of a file that are photographs of their own.

    Smaller copies and masks of other pages are none. A page whose header is damaged counts, as
    something to be reported. Files that are no TIFF, camera RAW (whose pages are previews) and what
    cannot be read as TIFF have page 1.

    Parameters
    ----------
    path : Path

    Raises
    ------
    Unmeasurable
        When the pages are the colours of one picture (ImageJ's composites, OME channels).
    """
    with path.open("rb") as file:
        if file.read(4) not in HEADS or path.suffix.lower() in RAW_SUFFIXES:
            return (1,)
    try:
        with tifffile.TiffFile(path) as tiff:
            return _photographs(path, tiff)
    except Unmeasurable:
        raise
    except Exception:  # the decoder says what is wrong
        return (1,)


def _photographs(path: Path, tiff: tifffile.TiffFile) -> tuple[int, ...]:
    count = len(tiff.pages)
    if count == 1 and not _goes_on(tiff):
        return tuple(range(1, _behind_one_header(tiff) + 1))
    coloured = (tiff.imagej_metadata or {}).get("mode") in ("composite", "color")
    if coloured or (tiff.is_ome and "C" in tiff.series[0].axes):
        raise Unmeasurable(f"{path}: holds {count} pictures and says that {CHANNELS}")
    kept = [n for n, page in enumerate(tiff.pages, 1) if not _subfile(page) & NO_PHOTOGRAPH]
    kept = kept or list(range(1, count + 1))
    return (*kept, count + 1) if _goes_on(tiff) else tuple(kept)


def _subfile(page: tifffile.TiffPage | tifffile.TiffFrame) -> int:
    return int(page.aspage().subfiletype)


def _behind_one_header(tiff: tifffile.TiffFile) -> int:
    """How many pictures follow the only header (ImageJ's stacks over 4 GB, volumes)."""
    series = tiff.series[0]
    lengths = zip(series.axes, series.shape, strict=True)
    return int(np.prod([length for axis, length in lengths if axis not in "YXS"]))


def _goes_on(tiff: tifffile.TiffFile) -> bool:
    """Whether the last readable header points to another: the file is cut or damaged there."""
    form, file = tiff.tiff, tiff.filehandle
    file.seek(tiff.pages[-1].offset)
    (tags,) = struct.unpack(form.tagnoformat, file.read(form.tagnosize))
    file.seek(tags * form.tagsize, 1)
    return any(file.read(form.offsetsize))


def without_header(path: Path, page: int) -> np.ndarray | None:
    """Pixels of a page that shares its header with all others; None where it has its own.

    Parameters
    ----------
    path : Path
    page : int
        From 1.

    Raises
    ------
    ValueError
        When the pixels are compressed.
    """
    with tifffile.TiffFile(path) as tiff:
        if len(tiff.pages) > 1 or _goes_on(tiff) or _behind_one_header(tiff) == 1:
            return None
        shape = tiff.series[0].keyframe.shape[-2:]
        if tiff.series[0].axes[-2:] != "YX":
            raise ValueError("colours behind one header; save each page as a file of its own")
    stack = tifffile.memmap(path, mode="r")
    return np.array(stack.reshape(-1, *shape)[page - 1]).astype(stack.dtype.newbyteorder("="))
