"""Read a photograph without losing bits, colours or its orientation."""

import warnings
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import tifffile
from PIL import ExifTags, Image

from imaging.errors import Unmeasurable

MIN_SIDE = 16  # pixels; nothing narrower holds a strand and its background
MAX_PIXELS = 200_000_000
RAW_SUFFIXES = {".cr2", ".cr3", ".nef", ".arw", ".dng", ".orf", ".raf", ".rw2"}
HEIF_SUFFIXES = {".heic", ".heif"}
# EXIF orientation -> (mirror left-right first, then quarter turns anticlockwise)
_UPRIGHT = {
    1: (False, 0),
    2: (True, 0),
    3: (False, 2),
    4: (True, 2),
    5: (True, 1),
    6: (False, 3),
    7: (True, 3),
    8: (False, 1),
}


@dataclass(frozen=True)
class Photo:
    """A photograph, upright, in sRGB.

    Attributes
    ----------
    pixels : (h, w, 3) uint8 or uint16 array
        sRGB-coded red, green, blue. Pixel centres lie at integer coordinates, x right, y down.
    source : str
        Where it was read from.
    ignore : (h, w) bool array or None
        True where the picture says nothing (transparent, outside the region of interest).
    exif : dict
        Camera, lens, time and so on, as strings.
    """

    pixels: np.ndarray
    source: str = "array"
    ignore: np.ndarray | None = None
    exif: dict[str, str] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.pixels.shape[0], self.pixels.shape[1]

    def rgb(self) -> np.ndarray:
        """Return sRGB-coded float32 in [0, 1], shape (h, w, 3)."""
        full = np.float32(np.iinfo(self.pixels.dtype).max)
        return np.divide(self.pixels, full, dtype=np.float32)


def read_photo(
    path: str | Path,
    *,
    roi: tuple[int, int, int, int] | None = None,
    ignore: str | Path | np.ndarray | None = None,
) -> Photo:
    """Read one photograph: JPEG, PNG, TIFF (8 or 16 bits), and HEIC or camera RAW with the extra.

    The EXIF orientation is applied. Transparent pixels and those outside `roi` are marked to be
    ignored. Grey pictures become RGB with equal channels; CMYK is converted to RGB.

    Parameters
    ----------
    path : path
        The picture's file.
    roi : (x0, y0, x1, y1) in pixels, optional
        Region of interest, upper left included, lower right excluded.
    ignore : path or (h, w) array, optional
        Mask of the same size as the upright picture; nonzero = do not look here.

    Returns
    -------
    Photo

    Raises
    ------
    Unmeasurable
        When the file is not a picture, is damaged, holds several pictures, or is too small.
    """
    path = Path(path)
    if not path.is_file():
        raise Unmeasurable(f"{path}: no such file; give the path of a photograph")
    pixels, exif, orientation = _decode(path)
    mirror, turns = _UPRIGHT.get(orientation, (False, 0))
    upright = np.rot90(pixels[:, ::-1] if mirror else pixels, turns)
    colour, hidden = _rgb_and_hidden(upright)
    if min(colour.shape[:2]) < MIN_SIDE:
        raise Unmeasurable(
            f"{path}: {colour.shape[1]} x {colour.shape[0]} pixels; "
            f"a photograph needs at least {MIN_SIDE} x {MIN_SIDE}"
        )
    hidden = _with_roi(path, hidden, roi)
    if ignore is not None:
        hidden |= _read_mask(path, ignore, hidden.shape)
    return Photo(np.ascontiguousarray(colour), str(path), hidden if hidden.any() else None, exif)


def _decode(path: Path) -> tuple[np.ndarray, dict[str, str], int]:
    """Pixels as stored (h, w) or (h, w, channels), EXIF as text, EXIF orientation."""
    suffix = path.suffix.lower()
    if suffix in RAW_SUFFIXES:
        return _decode_raw(path), {}, 1
    if suffix in HEIF_SUFFIXES:
        _open_heif(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _decode_common(path)
    except (OSError, SyntaxError, ValueError, tifffile.TiffFileError) as error:
        reason = " ".join(str(error).split())
        raise Unmeasurable(
            f"{path}: cannot be read as a picture ({reason}); export it as PNG, JPEG or TIFF"
        ) from error


def _decode_common(path: Path) -> tuple[np.ndarray, dict[str, str], int]:
    with Image.open(path) as image:
        _refuse_size_and_frames(path, image)
        tags = image.getexif()
        exif = {ExifTags.TAGS.get(key, str(key)): str(value) for key, value in tags.items()}
        # Pillow cuts 16-bit colour to 8 bits, so those files go to readers that keep them.
        if image.format == "TIFF" and _tiff_depth(image) > 8:
            pixels = tifffile.imread(path)
        elif image.format == "PNG" and _png_depth(path) == 16:
            image.load()  # raises when damaged; OpenCV would fill the rest with grey
            pixels = _png16(path)
        else:
            mode = "RGBA" if image.has_transparency_data else "RGB"
            pixels = np.asarray(image.convert(mode))
    return _eight_or_sixteen(path, pixels), exif, int(tags.get(ExifTags.Base.Orientation, 1))


def _refuse_size_and_frames(path: Path, image: Image.Image) -> None:
    frames = getattr(image, "n_frames", 1)
    if frames > 1 and image.format != "MPO":  # a phone's JPEG with a preview behind it
        raise Unmeasurable(f"{path}: holds {frames} pictures; export the one to be measured")
    width, height = image.size
    if width * height > MAX_PIXELS:
        raise Unmeasurable(
            f"{path}: {width} x {height} pixels is more than {MAX_PIXELS // 10**6} megapixels; "
            "crop or shrink it"
        )


def _tiff_depth(image: Image.Image) -> int:
    stated = image.getexif().get(ExifTags.Base.BitsPerSample, 8)
    return max(stated) if isinstance(stated, tuple) else int(stated)


def _png_depth(path: Path) -> int:
    """Bits per channel from the PNG header (byte 24 of the file)."""
    with path.open("rb") as file:
        return file.read(25)[24]


def _png16(path: Path) -> np.ndarray:
    stored = cv2.imdecode(np.fromfile(path, np.uint8), cv2.IMREAD_UNCHANGED)
    if stored is None:
        raise ValueError("damaged 16-bit PNG")
    if stored.ndim == 2:
        return stored
    order = cv2.COLOR_BGRA2RGBA if stored.shape[2] == 4 else cv2.COLOR_BGR2RGB
    return cv2.cvtColor(stored, order)


def _decode_raw(path: Path) -> np.ndarray:
    try:
        import rawpy
    except ImportError as error:
        raise Unmeasurable(
            f"{path}: camera RAW needs the extra: pip install 'combing[formats]'"
        ) from error
    try:
        with rawpy.imread(str(path)) as raw:
            return raw.postprocess(output_bps=16, no_auto_bright=True)
    except rawpy.LibRawError as error:
        raise Unmeasurable(f"{path}: cannot be read as camera RAW ({error})") from error


def _open_heif(path: Path) -> None:
    try:
        import pillow_heif
    except ImportError as error:
        raise Unmeasurable(
            f"{path}: HEIC needs the extra: pip install 'combing[formats]'"
        ) from error
    pillow_heif.register_heif_opener()


def _eight_or_sixteen(path: Path, pixels: np.ndarray) -> np.ndarray:
    if pixels.dtype == bool:
        return pixels.astype(np.uint8) * np.uint8(255)
    if pixels.dtype in (np.uint8, np.uint16):
        return pixels
    raise Unmeasurable(
        f"{path}: pixels are {pixels.dtype}; save the picture with 8 or 16 bits a channel"
    )


def _rgb_and_hidden(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Colour (h, w, 3) and the transparent pixels (h, w)."""
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    channels = pixels.shape[2]
    hidden = np.zeros(pixels.shape[:2], bool)
    if channels in (2, 4):
        hidden = pixels[..., -1] < np.iinfo(pixels.dtype).max // 2
        channels -= 1
    colour = pixels[..., :3] if channels == 3 else np.repeat(pixels[..., :1], 3, axis=2)
    return colour, hidden


def _with_roi(path: Path, hidden: np.ndarray, roi: tuple[int, int, int, int] | None) -> np.ndarray:
    if roi is None:
        return hidden
    x0, y0, x1, y1 = roi
    height, width = hidden.shape
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise Unmeasurable(
            f"{path}: region of interest {roi} does not lie in the picture "
            f"(0 <= x0 < x1 <= {width}, 0 <= y0 < y1 <= {height})"
        )
    outside = np.ones_like(hidden)
    outside[y0:y1, x0:x1] = False
    return hidden | outside


def _read_mask(path: Path, ignore: str | Path | np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    if isinstance(ignore, np.ndarray):
        mask = ignore != 0
    else:
        mask = read_photo(ignore).pixels.max(axis=2) > 0
    if mask.shape != shape:
        raise Unmeasurable(
            f"{path}: the ignore mask is {mask.shape[1]} x {mask.shape[0]} pixels, "
            f"the photograph {shape[1]} x {shape[0]}; they must agree"
        )
    return mask
