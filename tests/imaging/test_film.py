"""Films: frames one after the other, with their own times, upright; when something moves."""

import struct

import cv2
import numpy as np
import pytest

from imaging import Unmeasurable
from imaging.photo.film import Motion, frame_count, frames, is_film

SIZE = (96, 64)


def picture(number):
    """Paint a bright square in the upper left, and how many tenths of the width a bar reaches."""
    drawn = np.full((SIZE[1], SIZE[0], 3), 40, np.uint8)
    drawn[4:20, 4:20] = 220
    drawn[40:56, : 8 + 8 * number] = 180
    return drawn


def write_film(path, pictures, rate=10.0):
    height, width = pictures[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), rate, (width, height))
    for one in pictures:
        writer.write(one)
    writer.release()
    return path


@pytest.fixture
def film(tmp_path):
    return write_film(tmp_path / "run.mp4", [picture(k) for k in range(8)])


def test_frames_come_in_order_with_their_times(film):
    seen = list(frames(film))
    assert [one.number for one in seen] == list(range(8))
    np.testing.assert_allclose([one.time for one in seen], 0.1 * np.arange(8), atol=1e-6)
    bars = [int((one.pixels[48, :, 0] > 110).sum()) for one in seen]
    np.testing.assert_allclose(bars, 8 + 8 * np.arange(8), atol=3)
    assert frame_count(film) == 8


def test_frames_that_are_not_equally_far_apart_keep_their_times(film):
    """The table of durations says so: three frames of one length, five of three times that."""
    data = film.read_bytes().replace(b"edts", b"free")  # which cuts the film at its old length
    at = data.index(b"stts") - 4
    size, _, _, entries, _, delta = struct.unpack(">I4sIIII", data[at : at + 24])
    assert entries == 1
    table = struct.pack(">I4sIIIIII", size + 8, b"stts", 0, 2, 3, delta, 5, 3 * delta)
    data = bytearray(data[:at] + table + data[at + size :])
    for box in (b"moov", b"trak", b"mdia", b"minf", b"stbl"):
        place = data.index(box) - 4
        data[place : place + 4] = struct.pack(">I", struct.unpack_from(">I", data, place)[0] + 8)
    film.write_bytes(data)
    times = [one.time for one in frames(film)]
    np.testing.assert_allclose(times, np.r_[0, 1, 2, 3, 6, 9, 12, 15] / 10, atol=1e-3)


def test_a_film_is_upright_as_it_was_held(film):
    data = bytearray(film.read_bytes())
    matrix = struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30)
    at = data.index(matrix, data.index(b"tkhd"))
    data[at : at + 36] = struct.pack(">9i", 0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30)
    film.write_bytes(data)
    first = next(frames(film)).pixels
    assert first.shape[:2] == SIZE
    bright = [first[:24, :24].mean(), first[:24, -24:].mean()]
    assert bright[1] > bright[0] + 40  # turned clockwise: the square is at the upper right


def test_the_start_is_where_something_moves(tmp_path):
    rng = np.random.default_rng(1)
    still, moving = [picture(0)] * 12, [picture(k) for k in range(1, 8)]
    noisy = [np.clip(one + rng.normal(0, 4, one.shape), 0, 255).astype(np.uint8)
             for one in still + moving]  # fmt: skip
    motion = Motion()
    for frame in frames(write_film(tmp_path / "noisy.mp4", noisy)):
        motion.seen(frame)
    assert motion.start == pytest.approx(1.2, abs=0.11)


def test_where_nothing_moves_there_is_no_start_and_a_stated_one_stays(tmp_path):
    film = write_film(tmp_path / "still.mp4", [picture(0)] * 10)
    for told in (None, 0.3):
        motion = Motion(told)
        for frame in frames(film):
            motion.seen(frame)
        assert motion.start == told


def test_what_is_no_film_is_named(tmp_path):
    bad = tmp_path / "bad.mp4"
    bad.write_bytes(b"no film")
    for path, said in (
        (bad, "no film that OpenCV can read"),
        (tmp_path / "no.mov", "no such file"),
    ):
        with pytest.raises(Unmeasurable, match=said):
            list(frames(path))
    assert is_film(bad)
    assert not is_film(tmp_path / "photo.jpg")
