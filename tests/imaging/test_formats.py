"""HEIC and camera RAW, which need the extra; and what is said when it is missing."""

import sys

import numpy as np
import pytest
import tifffile
from PIL import Image

from imaging import Unmeasurable, read_photo

SRGB_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
LINEAR = {"red": (0.8, 0.1, 0.1), "grey": (0.5, 0.5, 0.5), "green": (0.1, 0.6, 0.1)}


@pytest.fixture
def scene() -> np.ndarray:
    """Draw a picture without any symmetry."""
    pixels = np.zeros((64, 96, 3), np.uint8)
    pixels[:, :30, 0] = 250
    pixels[:20, :, 1] = 200
    pixels[-10:, -10:, 2] = 150
    return pixels


@pytest.mark.parametrize(("orientation", "turns"), [(1, 0), (3, 2), (6, 3), (8, 1)])
def test_heic_is_read_upright(tmp_path, scene, orientation, turns):
    heif = pytest.importorskip("pillow_heif")
    heif.register_heif_opener()
    tags = Image.Exif()
    tags[274], tags[271] = orientation, "A camera"
    path = tmp_path / "photo.heic"
    Image.fromarray(scene).save(path, exif=tags.tobytes(), quality=95)
    photo = read_photo(path)
    upright = np.rot90(scene, turns)
    assert photo.shape == upright.shape[:2]
    assert np.abs(photo.pixels.astype(int) - upright).mean() < 4
    assert photo.exif["Make"] == "A camera"


def test_heic_that_is_called_jpeg_is_known_by_its_content(tmp_path, scene):
    heif = pytest.importorskip("pillow_heif")
    heif.register_heif_opener()
    Image.fromarray(scene).save(tmp_path / "photo.heic", quality=95)
    renamed = (tmp_path / "photo.heic").rename(tmp_path / "photo.jpg")
    assert read_photo(renamed).shape == scene.shape[:2]


def _negative(path, flip: int = 1) -> None:
    """Write a digital negative: three fields behind a Bayer filter, sRGB primaries, linear."""
    light = np.empty((120, 160, 3))
    light[:] = LINEAR["grey"]
    light[:, :60] = LINEAR["red"]
    light[:40] = LINEAR["green"]
    counts = np.round(16000 * light).astype(np.uint16)
    filtered = counts[..., 1].copy()
    filtered[0::2, 0::2], filtered[1::2, 1::2] = counts[0::2, 0::2, 0], counts[1::2, 1::2, 2]
    matrix = np.round(1e4 * np.linalg.inv(SRGB_TO_XYZ)).astype(int).ravel()
    tags = [
        (274, "H", 1, flip, True),
        (33421, "H", 2, (2, 2), True),  # CFARepeatPatternDim
        (33422, "B", 4, (0, 1, 1, 2), True),  # CFAPattern: red green, green blue
        (50706, "B", 4, (1, 4, 0, 0), True),  # DNGVersion
        (50708, "s", 0, "Test camera", True),  # UniqueCameraModel
        (50714, "H", 1, 0, True),  # BlackLevel
        (50717, "I", 1, 16000, True),  # WhiteLevel
        (50721, "2i", 9, [v for entry in matrix for v in (entry, 10000)], True),  # ColorMatrix1
        (50728, "2I", 3, [1] * 6, True),  # AsShotNeutral
        (50778, "H", 1, 21, True),  # CalibrationIlluminant1: D65
    ]
    tifffile.imwrite(
        path, filtered, photometric="cfa", extratags=tags, metadata=None, software=False
    )


def _coded(linear: tuple[float, ...]) -> np.ndarray:
    """Code linear light as sRGB (IEC 61966-2-1), in [0, 1]."""
    return 1.055 * np.array(linear) ** (1 / 2.4) - 0.055


def test_camera_raw_is_developed_to_srgb(tmp_path):
    pytest.importorskip("rawpy")
    _negative(tmp_path / "a.dng")
    photo = read_photo(tmp_path / "a.dng")
    assert photo.pixels.dtype == np.uint16
    for place, name in (((100, 20), "red"), ((100, 120), "grey"), ((10, 100), "green")):
        np.testing.assert_allclose(photo.rgb()[place], _coded(LINEAR[name]), atol=0.01)


def test_camera_raw_is_turned_upright(tmp_path):
    pytest.importorskip("rawpy")
    _negative(tmp_path / "a.dng", flip=6)
    photo = read_photo(tmp_path / "a.dng")
    assert photo.shape == (160, 120)
    np.testing.assert_allclose(photo.rgb()[20, 20], _coded(LINEAR["red"]), atol=0.01)


@pytest.mark.parametrize(
    ("name", "package", "what"),
    [("a.heic", "pillow_heif", "HEIC"), ("a.nef", "rawpy", "camera RAW")],
)
def test_the_extra_is_named_when_it_is_missing(tmp_path, monkeypatch, name, package, what):
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / name).write_bytes(b"\0\0\0\x20ftypheic" + 99 * b"x")
    with pytest.raises(Unmeasurable, match=rf"{what} needs the extra: pip install 'combing\[f"):
        read_photo(tmp_path / name)
