"""Picture file -> pixels as stored, EXIF and orientation; or one line why it is no picture."""

import warnings
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import tifffile
from PIL import ExifTags, Image, UnidentifiedImageError

from imaging.errors import Unmeasurable
from imaging.photo.pages import RAW_SUFFIXES, pages_of, without_header

MAX_PIXELS = 50_000_000  # answered from the file's head; some 50 bytes a pixel are needed later
HEIF_SUFFIXES = (".heic", ".heif")
COMMON_SUFFIXES = (".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff", ".webp")
SUFFIXES = (*COMMON_SUFFIXES, *HEIF_SUFFIXES, *RAW_SUFFIXES)
HEIF_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"mif1", b"msf1")
FORMATS = ("JPEG", "PNG", "TIFF", "BMP", "GIF", "WEBP", "PPM")
PREVIEWED = ("MPO", "HEIF")  # a phone's, with a preview behind the picture
EXPORT = "export it as PNG, JPEG or TIFF"
WHITE_IS_ZERO = 0  # TIFF's photometric interpretation


class Decoded(NamedTuple):
    """Pixels as stored, (h, w) or (h, w, channels) uint8 or uint16; EXIF as text; orientation."""

    pixels: np.ndarray
    exif: dict[str, str]
    orientation: int


class Picture(NamedTuple):
    """A picture file, or one page of it, from 1; as text, what messages call it."""

    path: Path
    page: int | None = None

    def __str__(self) -> str:
        return f"{self.path}" if self.page is None else f"{self.path}, page {self.page}"


def decode(path: Path, page: int | None = None) -> Decoded:
    """Decode a picture file, or one page of a TIFF.

    Parameters
    ----------
    path : Path
    page : int, optional
        From 1; only a file of one picture can go without.

    Raises
    ------
    Unmeasurable
        When the file is not there, is no picture, is damaged, holds several and no page is named,
        or has no such page.
    """
    kind = _kind(path)
    picture = Picture(path, page)
    if kind == "raw":
        if page not in (None, 1):
            raise Unmeasurable(f"{picture}: only a TIFF has pages; this is camera RAW")
        return Decoded(_decode_raw(path), {}, 1)
    if kind == "heif":
        _open_heif(path)
    formats = ("HEIF",) if kind == "heif" else FORMATS
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return _decode_common(picture, formats)
    except Unmeasurable:
        raise
    except Image.DecompressionBombError as error:
        raise Unmeasurable(f"{picture}: {_too_large('more than 170 million')}") from error
    except UnidentifiedImageError as error:
        raise _unreadable(picture, "its content is of no known format") from error
    except MemoryError as error:
        raise Unmeasurable(f"{picture}: does not fit into memory; crop or shrink it") from error
    except Exception as error:  # whatever a decoder makes of a damaged file
        raise _unreadable(picture, " ".join(f"{error}".split()) or type(error).__name__) from error


def _unreadable(picture: Picture | Path, reason: str) -> Unmeasurable:
    return Unmeasurable(f"{picture}: cannot be read as a picture ({reason}); {EXPORT}")


def _too_large(size: str) -> str:
    return (
        f"{size} pixels, more than {MAX_PIXELS // 10**6} megapixels; "
        "shrink it (strands 5 to 10 pixels wide are enough) or cut out the strands"
    )


def refuse_unless_file(path: Path) -> None:
    """Raise one clear line when there is no file at `path` that can be opened.

    Raises
    ------
    Unmeasurable
    """
    if path.is_dir():
        raise Unmeasurable(f"{path}: is a folder; give a photograph")
    if not path.exists():
        broken = path.is_symlink()
        reason = "a link that leads nowhere" if broken else "no such file"
        raise Unmeasurable(f"{path}: {reason}; give the path of a photograph")
    try:
        with path.open("rb") as file:
            file.read(1)
    except OSError as error:
        raise Unmeasurable(f"{path}: cannot be opened ({error.strerror})") from error


def _kind(path: Path) -> str:
    """Tell camera RAW (by its suffix) and HEIF (by its content, often named .jpg) from the rest."""
    refuse_unless_file(path)
    with path.open("rb") as file:
        head = file.read(12)
    if not head:
        raise _unreadable(path, "it is empty")
    if path.suffix.lower() in RAW_SUFFIXES:
        return "raw"
    return "heif" if head[4:8] == b"ftyp" and head[8:12] in HEIF_BRANDS else "common"


def _decode_common(picture: Picture, formats: tuple[str, ...]) -> Decoded:
    path = picture.path
    with Image.open(path, formats=formats) as image:
        page = _turn_to_page(picture, image)
        _refuse_size(picture, image)
        # Pillow cuts 16-bit colour to 8 bits, so those files go to readers that keep them.
        if image.format == "TIFF" and (bare := without_header(path, page)) is not None:
            pixels = bare
        elif image.format == "TIFF" and _tiff_depth(image) > 8:
            pixels = _deep_tiff(path, page)
        elif image.format == "PNG" and _png_depth(path) == 16:
            image.load()  # raises when damaged; OpenCV would fill the rest with grey
            pixels = _opencv(path)
        else:
            mode = "RGBA" if image.has_transparency_data else "RGB"
            pixels = np.asarray(image if image.mode == mode else image.convert(mode))
        exif, orientation = _exif(image)  # after decoding: Pillow turns 8-bit TIFF by itself
    return Decoded(_eight_or_sixteen(picture, pixels), exif, orientation)


def _exif(image: Image.Image) -> tuple[dict[str, str], int]:
    """EXIF as text and the orientation; a damaged block says nothing, and the picture stands."""
    try:
        tags = image.getexif()
        text = {ExifTags.TAGS.get(key, str(key)): str(value) for key, value in tags.items()}
        return text, int(tags.get(ExifTags.Base.Orientation, 1))
    except Exception:
        return {}, 1


def _turn_to_page(picture: Picture, image: Image.Image) -> int:
    """Turn an open file to the page to be read, and return its number; from 1."""
    if image.format != "TIFF":
        frames = getattr(image, "n_frames", 1)
        if frames > 1 and image.format not in PREVIEWED:
            raise Unmeasurable(
                f"{picture.path}: holds {frames} pictures; export the one to be measured, or all "
                "as a TIFF of several pages (of other formats no sequence is read)"
            )
        if picture.page not in (None, 1):
            raise Unmeasurable(f"{picture}: only a TIFF has pages; this is {image.format}")
        return 1
    pages = pages_of(picture.path)
    if picture.page is None and len(pages) > 1:
        raise Unmeasurable(
            f"{picture.path}: holds {len(pages)} pictures, one a page; export the one to be "
            "measured (`combing photo` measures each page, all else one photograph a file)"
        )
    page = pages[0] if picture.page is None else picture.page
    if page not in pages:
        raise Unmeasurable(f"{picture}: no such photograph; its pages are {_listed(pages)}")
    if without_header(picture.path, page) is None:
        try:
            image.seek(page - 1)
        except EOFError as error:
            raise ValueError("the file is cut off or damaged before this page") from error
    return page


def _listed(pages: tuple[int, ...]) -> str:
    """Say 1, 3, ..., 9: the first few and the last."""
    shown = [f"{page}" for page in pages]
    return ", ".join(shown if len(shown) < 6 else [*shown[:3], "...", shown[-1]])


def _refuse_size(picture: Picture, image: Image.Image) -> None:
    width, height = image.size
    if width * height > MAX_PIXELS:
        raise Unmeasurable(f"{picture}: {_too_large(f'{width} x {height}')}")


def _tiff_depth(image: Image.Image) -> int:
    stated = image.getexif().get(ExifTags.Base.BitsPerSample, 8)
    return max(stated) if isinstance(stated, tuple) else int(stated)


def _deep_tiff(path: Path, number: int) -> np.ndarray:
    """Pixels of a page of a TIFF with more than 8 bits, colours last, black = 0."""
    with tifffile.TiffFile(path) as file:
        page = file.pages[number - 1].aspage()
        try:
            pixels = page.asarray()
        except ValueError:  # a compression that tifffile leaves to a package of its own
            return _opencv(path, number)
        if page.axes.startswith("S"):
            pixels = np.moveaxis(pixels, 0, -1)
        white_is_zero = page.photometric == WHITE_IS_ZERO
    return np.iinfo(pixels.dtype).max - pixels if white_is_zero else pixels


def _png_depth(path: Path) -> int:
    """Bits per channel from the PNG header (byte 24 of the file)."""
    with path.open("rb") as file:
        return file.read(25)[24]


def _opencv(path: Path, page: int = 1) -> np.ndarray:
    """Pixels with all their bits, in the order red, green, blue, alpha."""
    coded = np.fromfile(path, np.uint8)
    if page == 1:
        stored = cv2.imdecode(coded, cv2.IMREAD_UNCHANGED)
    else:
        _, pages = cv2.imdecodemulti(coded, cv2.IMREAD_UNCHANGED, range=(page - 1, page))
        stored = pages[0] if pages else None
    if stored is None:
        raise ValueError("damaged, or compressed in an unknown way")
    if stored.ndim == 2:
        return stored
    order = cv2.COLOR_BGRA2RGBA if stored.shape[2] == 4 else cv2.COLOR_BGR2RGB
    return cv2.cvtColor(stored, order)


def _decode_raw(path: Path) -> np.ndarray:
    """Develop a camera RAW file: its own white balance, sRGB curve, upright."""
    try:
        import rawpy
    except ImportError as error:
        raise _needs_extra(path, "camera RAW") from error
    try:
        with rawpy.imread(str(path)) as raw:
            if raw.sizes.width * raw.sizes.height > MAX_PIXELS:
                size = f"{raw.sizes.width} x {raw.sizes.height}"
                raise Unmeasurable(f"{path}: {_too_large(size)}")
            return raw.postprocess(
                output_bps=16,
                gamma=(2.4, 12.92),
                use_camera_wb=True,
                no_auto_bright=True,
                adjust_maximum_thr=0,
            )
    except rawpy.LibRawError as error:
        reason = error.args[0].decode() if isinstance(error.args[0], bytes) else str(error)
        raise Unmeasurable(f"{path}: cannot be read as camera RAW ({reason}); {EXPORT}") from error


def _open_heif(path: Path) -> None:
    try:
        import pillow_heif
    except ImportError as error:
        raise _needs_extra(path, "HEIC") from error
    pillow_heif.register_heif_opener()


def _needs_extra(path: Path, what: str) -> Unmeasurable:
    return Unmeasurable(
        f"{path}: {what} needs the extra: pip install 'combing[formats]'; or {EXPORT}"
    )


def _eight_or_sixteen(picture: Picture, pixels: np.ndarray) -> np.ndarray:
    if pixels.ndim > 3 or (pixels.ndim == 3 and pixels.shape[2] > 4):
        shape = " x ".join(map(str, pixels.shape))
        raise Unmeasurable(f"{picture}: {shape} values are no single picture; {EXPORT}")
    if pixels.dtype in (np.uint8, np.uint16):
        return pixels
    raise Unmeasurable(
        f"{picture}: pixels are {pixels.dtype}; save the picture with 8 or 16 bits a channel"
    )
