"""The pinhole against closed forms, the drawn strand against its projected centreline."""

import builtins

import cv2
import numpy as np
import pytest

from combing.camera import Camera, Sensor, back_project, depth, expose, facing, project
from combing.errors import UserError

X, Y, Z = np.eye(3)
RADIUS, PITCH, HEIGHT = 4.25e-4, 18 * 4.25e-4, 0.03


def double_helix(nodes=400):
    z = np.linspace(0, HEIGHT, nodes)
    turn = 2 * np.pi * z / PITCH
    return [
        np.column_stack([z, RADIUS * np.cos(turn + lag), RADIUS * np.sin(turn + lag)])
        for lag in (0, np.pi)
    ]


def front_camera(size=(700, 120)):
    centre = np.array([HEIGHT / 2, 0, 0])
    return facing(centre, Z, Y, distance=0.7, pixel_size=RADIUS / 8, size=size)


def test_projection_is_similar_triangles():
    camera = Camera((0, 0, 0), (0, 0, 1), (0, 1, 0), 0.05, 1e-5, (641, 481))
    points = np.array([[0, 0, 2], [0.02, 0, 2], [0, 0.02, 2], [0.02, 0, 4]])
    # Looking along +z with y up, +x lies to the left of the picture.
    expected = np.array([[320, 240], [270, 240], [320, 190], [295, 240]])
    np.testing.assert_allclose(project(points, camera), expected, atol=1e-9)


def test_facing_gives_the_asked_pixel_size():
    camera = front_camera()
    ends = project(np.array([[0.01, 0, 0], [0.02, 0, 0], [0.01, 0.001, 0]]), camera)
    assert ends[1, 0] - ends[0, 0] == pytest.approx(0.01 / (RADIUS / 8), rel=1e-12)
    assert ends[0, 1] - ends[2, 1] == pytest.approx(0.001 / (RADIUS / 8), rel=1e-12)


def test_perspective_magnifies_what_is_nearer():
    camera = front_camera()
    near, far = (
        np.ptp(project(np.array([[0.01, 0, z], [0.02, 0, z]]), camera)[:, 0]) for z in (0.1, -0.1)
    )
    assert near / far == pytest.approx(0.8 / 0.6, rel=1e-12)


def test_back_projection_undoes_projection_on_a_tilted_plane():
    rng = np.random.default_rng(3)
    camera = Camera((0.1, -0.2, 0.9), (0, 0.02, 0), (0.1, 1, 0), 0.1, 7e-6, (3000, 500))
    origin, normal = np.array([0.01, 0.0, 0.02]), np.array([0.2, -0.1, 1.0])
    across = np.linalg.svd(normal[None])[2][1:]
    points = origin + rng.uniform(-0.05, 0.05, (50, 2)) @ across
    found = back_project(project(points, camera), camera, origin, normal)
    np.testing.assert_allclose(found, points, atol=1e-14)


def test_depth_is_measured_along_the_axis():
    camera = front_camera()
    np.testing.assert_allclose(depth(np.array([[0, 0.3, 0.2]]), camera), [0.5])


def test_points_behind_the_camera_are_refused():
    with pytest.raises(ValueError, match="behind"):
        project(np.array([[0.0, 0, 1]]), front_camera())


def test_sensor_noise_and_blur_are_as_stated():
    flat = np.full((300, 400, 3), 128, np.uint8)
    still = Sensor(blur=1.5, noise=0.03, dark_noise=0, uneven=0, vignette=0)
    spread = np.std(expose(flat, still, rng=1).astype(float) / 255)
    assert spread == pytest.approx(0.03 * np.sqrt(128 / 255), rel=0.02)
    edge = np.zeros((60, 200, 3), np.uint8)
    edge[:, 100:] = 200
    quiet = Sensor(blur=1.5, noise=0, dark_noise=0, uneven=0, vignette=0)
    profile = np.diff(expose(edge, quiet, rng=1)[30, :, 0].astype(float))
    at = np.arange(199)
    mean = np.sum(at * profile) / profile.sum()
    sd = np.sqrt(np.sum((at - mean) ** 2 * profile) / profile.sum())
    assert sd == pytest.approx(1.5, rel=0.06)


def test_sensor_is_repeatable_and_uneven():
    flat = np.full((200, 300, 3), 128, np.uint8)
    first, again, other = (expose(flat, Sensor(), rng=seed) for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    blocks = first[:, :, 0].reshape(4, 50, 6, 50).mean(axis=(1, 3))
    assert np.ptp(blocks) > 0.15 * blocks.mean()


def test_rendering_without_pyvista_says_what_to_install(monkeypatch):
    from combing import render

    whole = builtins.__import__

    def without(name, *args, **kwargs):
        if name.startswith("pyvista"):
            raise ImportError(name)
        return whole(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(UserError, match=r'pip install "combing\[render\]"'):
        render.render([], [], [], front_camera())


@pytest.fixture(scope="module")
def picture():
    pytest.importorskip("pyvista", reason="drawing needs the render extra")
    from combing.render import Marker, render

    marker = Marker(corner=np.array([0.02, 0.0025, 0]), right=X, down=-Y, side=0.0015)
    return render(
        double_helix(), [RADIUS] * 2, [(1, 0, 0), (0, 0, 1)], front_camera(), marker=marker
    )


def test_drawn_strand_lies_on_its_projected_centreline(picture):
    strands = double_helix()
    camera = front_camera()
    # The nearer strand hides the other; only points in front are compared.
    for channel, strand in ((0, strands[0]), (2, strands[1])):
        inside = strand[20:-20]
        front = inside[inside[:, 2] > 0.3 * RADIUS]
        column, row = np.round(project(front, camera)).astype(int).T
        colour = picture[row, column].astype(int)
        assert np.all(colour[:, channel] > 60)
        assert np.all(colour[:, channel] > colour[:, 2 - channel] + 40)


def test_drawn_width_is_the_diameter(picture):
    camera = front_camera()
    strand = double_helix()[0]
    # Where both strands lie in the picture plane, the outer edges are 4 r apart.
    side_by_side = np.flatnonzero(np.abs(np.diff(np.sign(strand[:, 2]))) > 0)
    columns = np.round(project(strand[side_by_side], camera)[:, 0]).astype(int)
    columns = columns[(columns > 60) & (columns < 400)]
    drawn = (picture[:, columns].max(axis=2) > 35).sum(axis=0)
    np.testing.assert_allclose(drawn, 4 * 8, atol=1.5)


def test_drawn_marker_is_found_at_its_place_and_size(picture):
    large = cv2.resize(picture, None, fx=4, fy=4, interpolation=cv2.INTER_CUBIC)
    finder = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50))
    corners, numbers, _ = finder.detectMarkers(large)
    assert numbers.ravel().tolist() == [0]
    found = (corners[0][0] + 0.5) / 4 - 0.5
    corner = np.array([0.02, 0.0025, 0])
    truth = corner + 0.0015 * np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [0, -1, 0]])
    np.testing.assert_allclose(found, project(truth, front_camera()), atol=0.6)


def test_tiles_join_without_a_seam(picture, monkeypatch):
    from combing import render

    monkeypatch.setattr(render, "TILE", 97)
    tiled = render.render(double_helix(), [RADIUS] * 2, [(1, 0, 0), (0, 0, 1)], front_camera())
    monkeypatch.setattr(render, "TILE", 4096)
    whole = render.render(double_helix(), [RADIUS] * 2, [(1, 0, 0), (0, 0, 1)], front_camera())
    difference = np.abs(whole.astype(int) - tiled)
    # Edges are sampled at other places inside a pixel; no pixel changes from strand to cloth.
    assert difference.mean() < 0.1
    assert difference.max() < 90
