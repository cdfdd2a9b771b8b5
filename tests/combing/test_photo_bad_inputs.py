"""What goes wrong with photographs, and the answer to each: one table, one test that walks it.

A refusal is one line that names the file and what would be right, exit code 2, and leaves nothing.
What can be measured is measured, with a note where its numbers are doubtful.
"""

import re
import struct
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pytest
import tifffile
from drawn.strands import Look, render
from PIL import Image

from combing.cli import main

SHAPE = (240, 200)
RED, GREEN, BLUE = (0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8)
GROUND = (0.9, 0.9, 0.88)
MEASURED = "3 strands, 5 crossings"
OK, REFUSED = 0, 2


class Case(NamedTuple):
    """A bad input: makes files in a folder and returns the arguments; what is answered to it."""

    make: Callable[[Path], object]
    answer: str
    code: int = REFUSED
    options: tuple[str, ...] = ()


@cache
def drawn(**changes) -> np.ndarray:
    """Draw three strands; `look` values, `colours`, `radius` or `stretch` may differ."""
    stretch, radius = changes.pop("stretch", 1.0), changes.pop("radius", 4)
    colours = changes.pop("colours", (RED, GREEN, BLUE))
    y = np.linspace(15, 225, 300)
    lines = [
        np.stack([100 + 40 * np.sin(y / 40 + 2.1 * i), 120 + stretch * (y - 120)], axis=1)
        for i in range(3)
    ]
    heights = [np.full(300, 20.0 * i) for i in range(3)]
    look = Look(background=GROUND, **changes)
    return render(lines, heights, colours, radius, SHAPE, look=look, rng=1).pixels


def saved(name: str, pixels: Callable[[], np.ndarray] = drawn, **options):
    """Make a case's file: these pixels, written by Pillow."""

    def make(folder: Path) -> Path:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        image = Image.fromarray(np.ascontiguousarray(pixels()))
        image.convert(options.pop("mode", image.mode)).save(path, **options)
        return path

    return make


def written(name: str, content: Callable[[], bytes]):
    def make(folder: Path) -> Path:
        (folder / name).write_bytes(content())
        return folder / name

    return make


def tiff(pixels: np.ndarray, **options):
    def make(folder: Path) -> Path:
        tifffile.imwrite(folder / "a.tif", pixels, **options)
        return folder / "a.tif"

    return make


def encoded(suffix: str, pixels: np.ndarray) -> bytes:
    return cv2.imencode(suffix, pixels[..., ::-1])[1].tobytes()


def even(level: int, shape: tuple[int, ...] = (*SHAPE, 3)) -> Callable[[], np.ndarray]:
    return lambda: np.full(shape, level, np.uint8)


def noise() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 255, (*SHAPE, 3), np.uint8)


def damaged_png() -> bytes:
    content = bytearray(encoded(".png", drawn()))
    content[len(content) // 2] ^= 0xFF
    return bytes(content)


def png_head(width: int, height: int) -> bytes:
    """Write a PNG that promises pixels and holds none."""
    head = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    check = struct.pack(">I", zlib.crc32(head))
    data = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + head + check
    empty = zlib.compress(b"")
    body = b"IDAT" + empty
    return data + struct.pack(">I", len(empty)) + body + struct.pack(">I", zlib.crc32(body))


def animation(folder: Path) -> Path:
    frames = [Image.fromarray(np.full((32, 32), v, np.uint8)) for v in (0, 255)]
    frames[0].save(folder / "a.gif", save_all=True, append_images=frames[1:])
    return folder / "a.gif"


def paletted(folder: Path) -> Path:
    Image.fromarray(drawn()).quantize(200, dither=Image.Dither.NONE).save(folder / "a.png")
    return folder / "a.png"


def with_glare() -> np.ndarray:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    spot = 600 * np.exp(-((x - 100) ** 2 + (y - 120) ** 2) / (2 * 20**2))
    return np.clip(0.75 * drawn() + spot[..., None], 0, 255).astype(np.uint8)


def cluttered() -> np.ndarray:
    picture, rng = drawn().copy(), np.random.default_rng(0)
    for _ in range(40):
        place = tuple(int(v) for v in rng.integers(0, 200, 2))
        ink = tuple(int(v) for v in rng.integers(0, 255, 3))
        cv2.circle(picture, place, int(rng.integers(2, 9)), ink, -1)
    return picture


def on_transparent() -> np.ndarray:
    alpha = np.full((*SHAPE, 1), 255, np.uint8)
    alpha[:, :20] = 0
    return np.concatenate([drawn(), alpha], axis=2)


def with_markers(count: int) -> Callable[[], np.ndarray]:
    def picture() -> np.ndarray:
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        wide = np.full((SHAPE[0], 500, 3), 235, np.uint8)
        wide[:, :200] = drawn()
        for i in range(count):
            marker = cv2.aruco.generateImageMarker(dictionary, 7 + i, 60)
            wide[20 + 100 * i : 80 + 100 * i, 300:360] = marker[..., None]
        return wide

    return picture


def exif(orientation: object) -> Image.Exif:
    tags = Image.Exif()
    tags[274] = orientation
    return tags


def corrupt_exif() -> bytes:
    content = encoded(".jpg", drawn())
    block = b"Exif\x00\x00II*\x00" + b"\xff" * 40
    return content[:2] + b"\xff\xe1" + struct.pack(">H", len(block) + 2) + block + content[2:]


def link_to(target: str | None):
    """Make a symlink; None = to itself."""

    def make(folder: Path) -> Path:
        path = folder / "a.jpg"
        path.symlink_to(path if target is None else target)
        return path

    return make


def both(*makers):
    return lambda folder: [make(folder) for make in makers]


def beside(other: Callable[[Path], object]):
    """Make another file (a mask, a board) beside the photograph."""

    def make(folder: Path) -> Path:
        other(folder)
        return GOOD(folder)

    return make


def folder_named_like_a_photograph(folder: Path) -> Path:
    (folder / "a.jpg").mkdir()
    return folder / "a.jpg"


GOOD = saved("a.png")
CASES = {
    # not there, or no picture
    "missing": Case(lambda d: d / "none.jpg", "none.jpg: no such file"),
    "pattern without match": Case(lambda d: d / "*.jpg", "no such file"),
    "empty folder": Case(lambda d: d, "no photographs .* in it"),
    "folder named like a photograph": Case(folder_named_like_a_photograph, "no photographs"),
    "zero bytes": Case(written("a.jpg", bytes), "cannot be read as a picture .*it is empty"),
    "text": Case(written("a.jpg", lambda: b"not a picture"), "of no known format.*export it as"),
    "spreadsheet": Case(written("a.png", lambda: b"PK\x03\x04" + 99 * b"x"), "no known format"),
    "video": Case(written("a.jpg", lambda: b"\0\0\0\x20ftypisom" + 99 * b"x"), "no known format"),
    "HEIC in name only": Case(
        written("a.heic", lambda: b"\0\0\0\x20ftypheic" + 99 * b"x"), "a.heic: "
    ),
    "RAW in name only": Case(written("a.nef", lambda: 999 * b"x"), "a.nef: .*camera RAW"),
    "link to itself": Case(link_to(None), "a link that leads nowhere"),
    "link to nothing": Case(link_to("gone.jpg"), "a link that leads nowhere"),
    "unreadable": Case(link_to("/proc/self/mem"), "cannot be opened"),
    # damaged
    "truncated JPEG": Case(
        written("a.jpg", lambda: encoded(".jpg", noise())[:9000]), "cannot be read.*truncated"
    ),
    "truncated PNG": Case(
        written("a.png", lambda: encoded(".png", drawn())[:9000]), "cannot be read as a picture"
    ),
    "truncated 16-bit PNG": Case(
        written("a.png", lambda: encoded(".png", noise().astype(np.uint16) * 257)[:9000]),
        "cannot be read as a picture",
    ),
    "damaged PNG": Case(written("a.png", damaged_png), "cannot be read as a picture"),
    "truncated TIFF": Case(
        written("a.tif", lambda: encoded(".tif", noise())[:9000]), "cannot be read as a picture"
    ),
    # wrong kind or size
    "one pixel": Case(saved("a.png", even(9, (1, 1, 3))), "1 x 1 pixels; .* at least 16 x 16"),
    "narrow": Case(saved("a.png", even(9, (500, 9, 3))), "9 x 500 pixels"),
    "100 megapixels": Case(
        written("a.png", lambda: png_head(12000, 8400)), "12000 x 8400 pixels, more than 50"
    ),
    "decompression bomb": Case(
        written("a.png", lambda: png_head(60000, 60000)), "pixels, more than 50 megapixels"
    ),
    "animated GIF": Case(animation, "holds 2 pictures; export the one"),
    "pages": Case(
        tiff(np.zeros((3, 32, 32), np.uint16), photometric="minisblack"), "none of the 3 photo"
    ),
    "float": Case(tiff(np.zeros((32, 32), np.float32)), "pixels are float32; save"),
    "not a number": Case(tiff(np.full((32, 32), np.nan, np.float32)), "pixels are float32"),
    "infinite": Case(tiff(np.full((32, 32), np.inf)), "a.tif: "),
    "five channels": Case(
        tiff(np.zeros((32, 32, 5), np.uint16), photometric="minisblack", planarconfig="contig"),
        "a.tif: ",
    ),
    # nothing to see
    "black": Case(saved("a.png", even(0)), "nothing stands out .*dark: .* expose longer"),
    "white": Case(saved("a.png", even(255)), "nothing stands out"),
    "grey card": Case(saved("a.png", even(128)), "nothing stands out"),
    "underexposed": Case(saved("a.png", lambda: drawn() // 16), "dark: its brightest part has 5 %"),
    "noise": Case(saved("a.png", noise), "nothing stands out"),
    "strands of the ground's colour": Case(
        saved("a.png", lambda: drawn(colours=(GROUND,) * 3, noise=0.02)), "nothing stands out"
    ),
    "one bit": Case(saved("a.png", mode="1"), "black and white dots"),
    "out of focus": Case(saved("a.png", lambda: drawn(blur=10)), "cannot be followed as a strand"),
    # the scale
    "scale of nonsense": Case(GOOD, "scale 'fast' is not understood", options=("--scale", "fast")),
    "scale without unit": Case(GOOD, "write it as 40px/mm", options=("--scale", "40")),
    "negative scale": Case(GOOD, "must be positive", options=("--scale", "-40px/mm")),
    "scale of zero": Case(GOOD, "must be positive", options=("--scale", "0px/mm")),
    "infinite scale": Case(GOOD, "must be positive", options=("--scale", "1e999px/mm")),
    "scale not a number": Case(GOOD, "not understood", options=("--scale", "nanpx/mm")),
    "doubt without per cent": Case(GOOD, "not understood", options=("--scale", "40px/mm+-1")),
    "no marker": Case(GOOD, "a.png: no ArUco marker", options=("--scale", "marker:20mm")),
    "two markers": Case(
        saved("a.png", with_markers(2)), "2 ArUco markers", options=("--scale", "marker:20mm")
    ),
    "no board": Case(GOOD, "a.png: no board found", options=("--scale", "charuco:7x5,15mm,11mm")),
    "marker for a board": Case(
        saved("a.png", with_markers(1)), "0 of the 24 corners .* at least 8",
        options=("--scale", "charuco:7x5,15mm,11mm"),
    ),
    "board of another size": Case(
        beside(saved("board.png", even(235, (99, 99, 3)))), "99 x 99 pixels, .* same camera",
        options=("--scale", "marker:20mm@FOLDER/board.png"),
    ),
    "board's photograph missing": Case(
        GOOD, "none.png: no such file", options=("--scale", "marker:20mm@FOLDER/none.png")
    ),
    "ruler without length": Case(
        GOOD, "two different points", options=("--scale", "ruler:5,5,5,5=10mm")
    ),
    # the region and the mask
    "region of three numbers": Case(GOOD, "give x0,y0,x1,y1", options=("--roi", "1,2,3")),
    "region outside": Case(GOOD, "does not lie in the picture", options=("--roi", "0,0,9000,90")),
    "region turned round": Case(GOOD, "does not lie", options=("--roi", "90,90,10,10")),
    "region of a few pixels": Case(GOOD, "at least 16 x 16", options=("--roi", "10,10,15,90")),
    "region of bare ground": Case(GOOD, "nothing stands out", options=("--roi", "0,0,40,40")),
    "region's mask missing": Case(GOOD, "region of interest", options=("--roi", "none.png")),
    "mask missing": Case(GOOD, "none.png: no such file", options=("--ignore", "none.png")),
    "mask of another size": Case(
        beside(saved("mask.png", even(255, (99, 99)))), "the mask .* 99 x 99 pixels, .* 200 x 240",
        options=("--ignore", "FOLDER/mask.png"),
    ),
    "mask over everything": Case(
        beside(saved("mask.png", even(255, SHAPE))), "leave nothing to look at",
        options=("--ignore", "FOLDER/mask.png"),
    ),
    # the output and the command
    "output is a file": Case(GOOD, "is a file", options=("-o", "FOLDER/a.png")),
    "output in a file": Case(GOOD, "is a file", options=("-o", "FOLDER/a.png/out")),
    "read-only output": Case(GOOD, "cannot be written", options=("-o", "/proc/out")),
    "output among the photographs": Case(
        GOOD, "folder of the photographs", options=("-o", "FOLDER")
    ),
    "no sections": Case(GOOD, "0 is not in the range", options=("--n-sec", "0")),
    "whole batch is bad": Case(
        both(saved("a.png", even(0)), written("b.jpg", bytes)), "none of the 2 photographs"
    ),
    # measured all the same
    "blurred": Case(saved("a.png", lambda: drawn(blur=4)), "note: blurred: edges are soft", OK),
    "glare": Case(saved("a.png", with_glare), r"note: strand \d ends in glare at x = \d+, y", OK),
    "leaving the picture": Case(
        saved("a.png", lambda: drawn(stretch=1.4)), "note: strands leave the picture: 1, 2, 3", OK
    ),
    "thin strands": Case(
        saved("a.png", lambda: drawn(radius=1.2)), "px wide; at least 4 px are needed", OK
    ),
    "clutter": Case(saved("a.png", cluttered), MEASURED, OK),
    "uneven light": Case(saved("a.png", lambda: drawn(uneven=0.6)), MEASURED, OK),
    "no scale": Case(GOOD, f"(?s){MEASURED}.*no scale: lengths in pixels", OK),
    "CMYK": Case(saved("a.jpg", mode="CMYK", quality=95), MEASURED, OK),
    "alpha": Case(saved("a.png", on_transparent), MEASURED, OK),
    "palette": Case(paletted, MEASURED, OK),
    "16 bits": Case(tiff(drawn().astype(np.uint16) * 257, photometric="rgb"), MEASURED, OK),
    "planes apart": Case(
        tiff(np.moveaxis(drawn(), -1, 0).astype(np.uint16) * 257, photometric="rgb",
             planarconfig="separate"), MEASURED, OK,
    ),
    "grey": Case(saved("a.png", mode="L"), "strand", OK),
    "turned by EXIF": Case(saved("a.jpg", exif=exif(6), quality=95), "3 strands", OK),
    "impossible EXIF": Case(saved("a.jpg", exif=exif(99), quality=95), "3 strands", OK),
    "corrupt EXIF": Case(written("a.jpg", corrupt_exif), "3 strands", OK),
    "blanks and signs in the name": Case(saved("Büschel no. 1 (ä; ’b’) 梳.png"), MEASURED, OK),
    "suffix in capitals": Case(saved("A.PNG"), MEASURED, OK),
    "JPEG called PNG": Case(written("a.png", lambda: encoded(".jpg", drawn())), "3 strands", OK),
    "same name twice, and a bad one": Case(
        both(saved("one/a.png"), saved("two/a.png"), written("b.jpg", bytes)),
        r"(?s)b.jpg: REFUSED.*2 measured, 1 refused", OK,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_every_bad_input_gets_its_answer(tmp_path, capsys, name):
    case = CASES[name]
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    made = case.make(folder)
    files = [str(path) for path in (made if isinstance(made, list) else [made])]
    options = [one.replace("FOLDER", str(folder)) for one in case.options]
    before = sorted(folder.rglob("*"))
    with pytest.raises(SystemExit) as leaving:
        main(["photo", *files, "-o", str(out), "--quiet", *options])
    told = capsys.readouterr()
    assert leaving.value.code == case.code, told
    if case.code == REFUSED:
        assert re.search(case.answer, told.err), told.err
        assert told.err.startswith("combing: ")
        assert told.err.count("\n") == 1
        assert not [p for p in out.rglob("*") if p.name != "summary.json"]
    else:
        assert re.search(case.answer, told.out), told.out
    assert sorted(folder.rglob("*")) == before
    assert not [p for p in tmp_path.rglob("*") if "partial" in p.name]


def test_there_are_enough_cases():
    assert len(CASES) >= 40
