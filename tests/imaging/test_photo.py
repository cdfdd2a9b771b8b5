"""Pixels as the camera meant them, or one clear line why not."""

from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from imaging import Photo, Unmeasurable, read_photo

H, W = 20, 30


@pytest.fixture
def scene() -> np.ndarray:
    """Draw a picture without any symmetry: red left, green top, blue a corner."""
    pixels = np.zeros((H, W, 3), np.uint8)
    pixels[:, :10, 0] = 250
    pixels[:6, :, 1] = 200
    pixels[-4:, -4:, 2] = 150
    return pixels


def _as_stored(upright: np.ndarray, orientation: int) -> np.ndarray:
    """Undo what an EXIF orientation asks for (CIPA DC-008 table 6), written out by hand."""
    transposed = upright.transpose(1, 0, 2)
    return {
        1: upright,
        2: upright[:, ::-1],
        3: upright[::-1, ::-1],
        4: upright[::-1],
        5: transposed,
        6: transposed[::-1],
        7: transposed[::-1, ::-1],
        8: transposed[:, ::-1],
    }[orientation]


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_exif_orientation_is_applied(tmp_path, scene, orientation, suffix):
    exif = Image.Exif()
    exif[274] = orientation
    path = tmp_path / f"a.{suffix}"
    Image.fromarray(np.ascontiguousarray(_as_stored(scene, orientation))).save(path, exif=exif)
    np.testing.assert_array_equal(read_photo(path).pixels, scene)


def test_opencv_agrees_on_a_rotated_jpeg(tmp_path, scene):
    exif = Image.Exif()
    exif[274] = 6
    path = tmp_path / "a.jpg"
    Image.fromarray(scene).save(path, exif=exif, quality=95)
    by_opencv = cv2.imread(str(path), cv2.IMREAD_COLOR)[..., ::-1]
    difference = read_photo(path).pixels.astype(int) - by_opencv
    assert np.abs(difference).max() <= 4  # decoders round differently


@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_sixteen_bits_are_kept(tmp_path, scene, suffix):
    deep = scene.astype(np.uint16) * 257 - (scene > 0)  # not a multiple of 257
    path = tmp_path / f"deep.{suffix}"
    if suffix == "png":
        cv2.imwrite(str(path), deep[..., ::-1])
    else:
        tifffile.imwrite(path, deep, photometric="rgb")
    photo = read_photo(path)
    assert photo.pixels.dtype == np.uint16
    np.testing.assert_array_equal(photo.pixels, deep)
    assert photo.rgb().max() <= 1


def test_grey_becomes_equal_channels(tmp_path, scene):
    path = tmp_path / "grey.png"
    Image.fromarray(scene[..., 0]).save(path)
    np.testing.assert_array_equal(read_photo(path).pixels, np.repeat(scene[..., :1], 3, axis=2))


def test_transparent_pixels_are_ignored(tmp_path, scene):
    alpha = np.full((H, W, 1), 255, np.uint8)
    alpha[:, :5] = 0
    path = tmp_path / "alpha.png"
    Image.fromarray(np.concatenate([scene, alpha], axis=2)).save(path)
    photo = read_photo(path)
    assert photo.ignore is not None
    np.testing.assert_array_equal(photo.ignore, alpha[..., 0] == 0)


def test_cmyk_is_converted(tmp_path, scene):
    path = tmp_path / "cmyk.jpg"
    Image.fromarray(scene).convert("CMYK").save(path, quality=95)
    assert np.abs(read_photo(path).pixels.astype(int) - scene).mean() < 8


def test_region_and_mask_are_joined(tmp_path, scene):
    path = tmp_path / "a.png"
    Image.fromarray(scene).save(path)
    mask = np.zeros((H, W), np.uint8)
    mask[3, 4] = 1
    ignore = read_photo(path, roi=(2, 1, 20, 18), ignore=mask).ignore
    assert ignore is not None
    assert ignore[3, 4]
    assert ignore[0, 5]
    assert ignore[18, 5]
    assert not ignore[17, 19]
    assert (~ignore).sum() == 18 * 17 - 1


def _write(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


def _jpeg() -> bytes:
    noise = np.random.default_rng(1).integers(0, 255, (200, 200, 3), np.uint8)
    return cv2.imencode(".jpg", noise)[1].tobytes()


def _saved(path: Path, pixels: np.ndarray, **options) -> Path:
    Image.fromarray(pixels).save(path, **options)
    return path


def _animation(path: Path) -> Path:
    frames = [Image.fromarray(np.full((32, 32), v, np.uint8)) for v in (0, 255)]
    frames[0].save(path, save_all=True, append_images=frames[1:])
    return path


def _float_tiff(path: Path) -> Path:
    tifffile.imwrite(path, np.zeros((32, 32), np.float32))
    return path


REFUSED = {
    "missing": (lambda d: d / "none.jpg", "no such file"),
    "folder": (lambda d: d, "is a folder"),
    "empty": (lambda d: _write(d / "a.jpg", b""), "cannot be read as a picture"),
    "text": (lambda d: _write(d / "a.jpg", b"not a picture"), "cannot be read as a picture"),
    "truncated jpeg": (lambda d: _write(d / "a.jpg", _jpeg()[:5000]), "truncated"),
    "one pixel": (lambda d: _saved(d / "a.png", np.zeros((1, 1, 3), np.uint8)), "1 x 1 pixels"),
    "narrow": (lambda d: _saved(d / "a.png", np.zeros((500, 9, 3), np.uint8)), "9 x 500 pixels"),
    "animated gif": (lambda d: _animation(d / "a.gif"), "holds 2 pictures"),
    "float tiff": (lambda d: _float_tiff(d / "a.tif"), "float32"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_files_are_refused_in_one_line(tmp_path, case):
    make, reason = REFUSED[case]
    with pytest.raises(Unmeasurable, match=reason) as caught:
        read_photo(make(tmp_path))
    assert "\n" not in str(caught.value)
    assert str(tmp_path) in str(caught.value)


def test_truncated_sixteen_bit_png_is_refused(tmp_path):
    path = tmp_path / "deep.png"
    deep = np.random.default_rng(1).integers(0, 65535, (64, 64, 3), np.uint16)
    cv2.imwrite(str(path), deep)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(Unmeasurable, match="cannot be read"):
        read_photo(path)


@pytest.mark.parametrize("roi", [(0, 0, 31, 5), (5, 5, 5, 9), (-1, 0, 4, 4)])
def test_region_outside_the_picture_is_refused(tmp_path, scene, roi):
    path = _saved(tmp_path / "a.png", scene)
    with pytest.raises(Unmeasurable, match="does not lie in the picture"):
        read_photo(path, roi=roi)


def test_photo_knows_its_shape(scene):
    assert Photo(scene).shape == (H, W)
