"""A measured double helix against the truth of drawn photographs."""

import helix_unlike
import numpy as np
import pytest
from drawn.helix import BLUE, RED, Light, draw_helix, draw_tubes
from drawn.helix_accuracy import beside_truth, total_link_error, window_errors

from imaging import Photo, Segmentation, Unmeasurable
from imaging.helix import find, helix, photograph
from imaging.helix.counted import may_wind

R = 6.0
PITCH = 18 * R


def drawn(turns=6, sign=1, **options):
    options.setdefault("rng", 1)
    return draw_helix(R, lambda s: sign / PITCH, turns * PITCH, **options)


def exact(picture):
    """Wrap the drawn coverage as a segmentation without error."""
    labels = np.where(
        picture.membership.sum(axis=0) > 0.5, picture.membership.argmax(axis=0) + 1, 0
    )
    colours = np.zeros((len(picture.membership), 3))
    return Segmentation(labels.astype(np.int32), picture.membership, colours, 2 * R)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.fixture(scope="module")
def photographed():
    picture = drawn()
    return picture, helix(Photo(picture.pixels))


def test_link_density_of_a_photograph(photographed):
    picture, found = photographed
    table = beside_truth(found, picture)
    assert rms(window_errors(table, PITCH)) < 1.2e-3
    assert abs(total_link_error(table, found)) < 0.05


def test_radius_at_contact_is_not_biased_by_the_hidden_strand(photographed):
    _, found = photographed
    assert pytest.approx(R, rel=0.02) == found.R
    assert found.unit == "px"


def test_link_density_table_is_resolved_but_at_the_ends(photographed):
    _, found = photographed
    link = found.link_density
    assert list(link.columns) == ["s", "link", "sd"]
    known = link["link"].notna()
    assert known.mean() > 0.9
    assert (link["sd"][known] > 0).all()
    assert found.phase["s"].is_monotonic_increasing


@pytest.mark.parametrize(("sign", "name"), [(1, "right"), (-1, "left")])
@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_handedness(sign, name, phase):
    found = helix(exact(drawn(turns=4, sign=sign, phase=phase)))
    assert found.handedness == name
    assert np.sign(found.total_link) == sign


def test_a_mirror_turns_the_hand_and_nothing_else():
    segmentation = exact(drawn(turns=4))
    mirrored = Segmentation(
        segmentation.labels[:, ::-1], np.ascontiguousarray(segmentation.membership[:, :, ::-1]),
        segmentation.colours, segmentation.width,
    )  # fmt: skip
    one, other = helix(segmentation), helix(mirrored)
    assert other.total_link == pytest.approx(-one.total_link, abs=0.01)
    assert other.pitch == pytest.approx(one.pitch, rel=1e-3)


def test_upside_down_keeps_the_hand_and_the_link():
    segmentation = exact(drawn(turns=4))
    turned = Segmentation(
        segmentation.labels[::-1, ::-1],
        np.ascontiguousarray(segmentation.membership[:, ::-1, ::-1]),
        segmentation.colours, segmentation.width,
    )  # fmt: skip
    one, other = helix(segmentation), helix(turned, root="bottom")
    assert other.total_link == pytest.approx(one.total_link, abs=0.01)


def test_a_step_is_located():
    place = 4 * PITCH
    picture = draw_helix(
        R, lambda s: np.where(s < place, 1 / PITCH, 0.75 / PITCH), 8 * PITCH, rng=1
    )
    table = beside_truth(helix(Photo(picture.pixels)), picture)
    found = table["true_s"][table["link"] > 0.875 / PITCH].max()
    assert abs(found - place) < 0.5 * PITCH
    near = (table["true_s"] - place).abs() < PITCH
    assert rms((table["link"] / table["true_link"] - 1)[near]) < 0.025


@pytest.mark.parametrize("angle", [10, -10])
def test_a_helix_that_leans_out_of_the_picture_is_corrected_and_flagged(angle):
    picture = drawn(turns=6, tilt=np.radians(angle))
    found = helix(exact(picture))
    assert np.degrees(found.lean) == pytest.approx(angle, abs=1.0)
    assert found.pitch == pytest.approx(PITCH, rel=5e-3)
    assert any("leans" in said for said in found.warnings)


def test_a_kink_keeps_the_link():
    def heading(s):
        return np.pi / 2 * np.clip((s - 3 * PITCH) / (np.pi / 2 * 4 * R) + 0.5, 0, 1)

    picture = drawn(turns=6, heading=heading)
    found = helix(exact(picture))
    error = total_link_error(beside_truth(found, picture), found)
    assert abs(error / found.total_link) < 0.02


def test_a_wider_helix_shows_gaps_between_the_strands():
    picture = drawn(turns=6, helix_radius=1.8 * R)
    found = helix(exact(picture))
    assert pytest.approx(1.8 * R, rel=0.02) == found.R
    assert rms(window_errors(beside_truth(found, picture), PITCH)) < 2e-3


def test_link_is_counted_across_a_tine_that_is_given():
    segmentation = exact(drawn(turns=6))
    whole = helix(segmentation)
    x, y = whole.axis[len(whole.axis) // 2]
    hidden = segmentation.membership.copy()
    hidden[:, int(y - 2 * R) : int(y + 2 * R)] = 0
    labels = np.where(hidden.sum(axis=0) > 0.5, segmentation.labels, 0)
    found = helix(
        Segmentation(labels, hidden, segmentation.colours, segmentation.width), tine=(x, y, 2 * R)
    )
    assert found.total_link == pytest.approx(whole.total_link, abs=0.02)
    row = int(np.abs(found.phase["s"] - found.tine).argmin())
    assert np.isnan(found.link_density["link"].iloc[row])


def hidden_tine(width):
    """Hide ``width`` pitches in the middle of six turns; return the error of the link."""
    picture = drawn(turns=6)
    segmentation = exact(picture)
    hidden = segmentation.membership.copy()
    middle, half = hidden.shape[1] / 2, 0.5 * width * PITCH
    hidden[:, int(middle - half) : int(middle + half)] = 0
    labels = np.where(hidden.sum(axis=0) > 0.5, segmentation.labels, 0)
    found = helix(
        Segmentation(labels, hidden, segmentation.colours, segmentation.width),
        tine=(hidden.shape[2] / 2, middle, half),
    )
    return found, total_link_error(beside_truth(found, picture), found)


def test_a_gap_of_less_than_half_a_pitch_is_counted_over():
    found, error = hidden_tine(0.3)
    assert abs(error) < 0.02
    assert not any("not determined" in said for said in found.warnings)


def test_winding_across_a_gap_of_most_of_a_pitch_is_said_to_be_undetermined():
    found, error = hidden_tine(0.8)
    assert any("winding across it is not determined" in said for said in found.warnings)
    assert abs(error - round(error)) < 0.05  # right but for whole turns


@pytest.mark.parametrize("radius", [1.5, 3.0, 5.0])
def test_a_tine_is_found_however_thick_and_a_clamp_is_none(radius):
    """A bar of another colour across the photograph [strand radii]; above, a clamp as wide."""
    colours = (RED, BLUE, (60, 140, 60))
    picture = drawn(tine=(3.2 * PITCH, radius * R), colours=colours)
    pixels = picture.pixels.copy()
    pixels[: int(6 * R)] = pixels[int(picture.truth["y"].iloc[0] + 3.2 * PITCH), 0]
    found = helix(Photo(pixels))
    row = int(np.abs(found.phase["s"] - found.tine).argmin())
    place = np.interp(found.axis[row, 1], picture.truth["y"], picture.truth["s"])
    assert place == pytest.approx(3.2 * PITCH, abs=R)


def splayed(turns, phase, apart=1.5 * PITCH):
    """Strands that wind no more over their last pitch and a half, and part there."""
    length = turns * PITCH

    def splay(s):
        return np.clip((s - (length - apart)) / apart, 0, 1)

    return draw_helix(
        R, lambda s: np.where(splay(s) > 0, 0.0, 1 / PITCH), length,
        helix_radius=lambda s: R * (1 + 3 * splay(s) ** 2), phase=phase, rng=6,
    )  # fmt: skip


@pytest.mark.parametrize("phase", [0.375 * np.pi, np.pi])
def test_where_tips_splay_link_is_not_run_on(phase):
    """In the picture or partly out of it: edges that the fit leaves out show where it ends."""
    picture = splayed(4.5, phase)
    found = helix(Photo(picture.pixels))
    table = beside_truth(found, picture)
    assert abs(total_link_error(table, found)) < 0.05
    assert (table["link"] * PITCH < 1.05).all()
    assert table["true_s"].max() > 2.5 * PITCH


def test_splayed_tips_are_not_measured_and_do_no_harm():
    apart = 1.5 * PITCH
    length = 6 * PITCH
    picture = splayed(6, np.pi, apart)
    found = helix(exact(picture))
    table = beside_truth(found, picture)
    assert table["true_s"].max() < length - 0.5 * apart
    assert table["true_s"].max() > length - 2.5 * apart
    above = table[table["true_s"] < length - apart - 0.5 * PITCH]
    assert rms(window_errors(above, PITCH)) < 0.002
    assert found.tine is None


def test_where_the_outline_is_not_a_helix_nothing_is_resolved():
    """A blot on the pair: no phase has its outline."""
    picture = drawn(turns=6)
    spoiled = picture.membership.copy()
    y, x = np.ogrid[: spoiled.shape[1], : spoiled.shape[2]]
    middle = spoiled.shape[1] / 2
    blot = np.hypot(x - np.interp(middle, picture.truth["y"], picture.truth["x"]), y - middle) < 22
    spoiled[0][blot], spoiled[1][blot] = 1.0, 0.0
    labels = np.where(spoiled.sum(axis=0) > 0.5, spoiled.argmax(axis=0) + 1, 0)
    found = helix(Segmentation(labels.astype(np.int32), spoiled, np.zeros((2, 3)), 2 * R))
    near = (found.phase["y"] - middle).abs() < R
    far = (found.phase["y"] - middle).abs().between(PITCH, 2 * PITCH)
    assert not (found.phase["by"] == "edges")[near].any()
    assert found.phase["resolved"][far].all()
    assert any("not resolved from" in said for said in found.warnings[1:])


def test_an_axis_wound_in_space_is_measured_in_space():
    """A pair whose axis winds out of the picture and back: longer than seen, and it writhes."""
    s = np.linspace(0, 8 * PITCH, 4000)
    angle = 2 * np.pi * s / (2.0 * PITCH)
    slope = 0.35 * np.clip(np.minimum(s, s[-1] - s) / PITCH, 0, 1)
    tangent = np.column_stack([slope * np.cos(angle), np.sqrt(1 - slope**2), slope * np.sin(angle)])
    axis = np.vstack([np.zeros(3), np.cumsum(0.5 * (tangent[1:] + tangent[:-1]), axis=0)])
    axis[1:] *= s[1]
    normal = np.cross(tangent, [0.0, 0, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    across = np.cross(tangent, normal)
    phi = 2 * np.pi * s / PITCH
    arm = R * (np.cos(phi)[:, None] * normal + np.sin(phi)[:, None] * across)
    strands = [p * [1, 1, -1] + [8 * R + 30, 6 * R, 0] for p in (axis + arm, axis - arm)]
    shape = (int(strands[0][:, 1].max() + 6 * R), int(16 * R + 60))
    pixels, membership = draw_tubes(
        strands, R, shape, colours=(RED, BLUE), background=(235, 235, 230), blur=1.0, noise=0.02,
        light=Light(), rng=1,
    )  # fmt: skip
    found = helix(Photo(pixels))
    resolved = found.phase["resolved"].to_numpy()
    length = found.phase["s"][resolved].iloc[-1] - found.phase["s"][resolved].iloc[0]
    seen = np.linalg.norm(np.diff(found.axis[resolved], axis=0), axis=1).sum()
    share = length / s[-1]
    assert length / seen == pytest.approx(1 / np.sqrt(1 - 0.35**2 / 2), rel=0.03)
    assert np.sign(found.total_link) * share * 8 == pytest.approx(found.total_link, rel=0.06)


def test_before_a_dark_cloth_shading_does_not_move_the_edges():
    """Light from one side leaves one rim of a strand at a third of the light of its middle.

    Edges at half of the light lie up to 1.5 px inside there; R read 5 % low and lambda 0.3 % off.
    """
    r, pitch = 8.0, 18 * 8.0
    picture = draw_helix(
        r, lambda s: 1 / pitch, 5 * pitch, tilt=np.radians(4), background=(24, 24, 24),
        light=Light(direction=(0.6, -0.5, 0.6), ambient=0.3), rng=7,
    )  # fmt: skip
    found = helix(Photo(picture.pixels))
    table = beside_truth(found, picture)
    assert pytest.approx(r, rel=0.015) == found.R
    assert pytest.approx(r, rel=0.03) == found.r
    assert np.degrees(found.lean) == pytest.approx(4.0, abs=2.0)
    assert np.mean(np.abs(table["link"] - table["true_link"]) < 2.5 * table["sd"]) > 0.9


def test_a_dark_strand_before_a_dark_cloth_is_found():
    """Single pixels of the cloth scatter by as much as the green strand stands out."""
    picture = drawn(
        4, colours=((30, 110, 60), (220, 170, 30)), background=(50, 52, 40), noise=0.03,
        light=Light((0.5, -0.4, 0.8), ambient=0.2), phase=1.0,
    )  # fmt: skip
    found = helix(Photo(picture.pixels))
    table = beside_truth(found, picture)
    assert abs(total_link_error(table, found)) < 0.05
    assert rms(table["link"] / table["true_link"] - 1) < 0.03


def test_where_the_light_shows_too_few_edges_coverage_is_used():
    """Blue before green: little of a step in the light, whose few edges determined no helix."""
    r, pitch = 6.5, 15 * 6.5
    picture = draw_helix(
        r, lambda s: -(1 + 0.1 * np.sin(2 * np.pi * s / (5 * pitch))) / pitch, 5 * pitch,
        background=(34, 56, 28), blur=1.2, noise=0.014, phase=2.17, rng=1,
        light=Light((-0.27, -0.09, 0.8), ambient=0.41, highlight=0.2, uneven=0.2),
    )  # fmt: skip
    table = beside_truth(helix(Photo(picture.pixels)), picture)
    assert rms(table["link"] / table["true_link"] - 1) < 0.02
    assert np.mean(np.abs(table["link"] - table["true_link"]) < 1.96 * table["sd"]) > 0.9


def test_scale_turns_pixels_into_metres():
    segmentation = exact(drawn(turns=4))
    pixels, metres = helix(segmentation), helix(segmentation, scale=20_000.0)
    assert metres.unit == "m"
    assert metres.pitch == pytest.approx(pixels.pitch / 20_000)
    assert pytest.approx(pixels.R / 20_000) == metres.R
    assert metres.total_link == pixels.total_link
    assert metres.link_density["link"].median() == pytest.approx(1 / metres.pitch, rel=1e-2)


def test_mean_link_between_two_places_is_that_of_the_table(photographed):
    _, found = photographed
    s = found.link_density["s"][found.link_density["link"].notna()]
    value, sd = found.mean_link(s.iloc[0], s.iloc[-1])
    assert value == pytest.approx(1 / found.pitch, rel=1e-6)
    assert 0 < sd < 0.01 * value
    # Between the same ends turns and lengths err as the pitch does; once, not twice.
    assert sd / value == pytest.approx(found.pitch_sd / found.pitch, rel=1e-6)


def test_one_strand_is_refused():
    picture = drawn(turns=3)
    alone = exact(picture)
    alone = Segmentation(
        (picture.membership[0] > 0.5).astype(np.int32),
        picture.membership[:1],
        alone.colours[:1],
        2 * R,
    )
    with pytest.raises(Unmeasurable, match="two strands of different colours"):
        helix(alone)


def test_straight_neighbours_are_refused():
    picture = draw_helix(R, lambda s: 0.0, 6 * PITCH, phase=0.0, rng=1)
    with pytest.raises(Unmeasurable, match="swap sides 0 times"):
        helix(exact(picture))


def test_a_large_picture_is_asked_coarsely_whether_anything_winds(monkeypatch):
    """Cables that may wind were looked at in every of twelve million pixels: a minute."""
    picture = Photo(draw_helix(R, lambda s: 0.0, 6 * PITCH, phase=0.0, rng=1).pixels)
    monkeypatch.setattr(photograph, "find_pairs", lambda photo: ([], True))
    monkeypatch.setattr(find, "FINEST", 500)
    monkeypatch.setattr(photograph, "segment", None)  # never looked at in full
    with pytest.raises(Unmeasurable, match="no two strands of different colours"):
        helix(picture)


@pytest.mark.parametrize(("link", "winds"), [(1 / PITCH, True), (0.0, False)])
def test_a_dark_pair_may_wind_and_straight_neighbours_do_not(link, winds):
    look = {"colours": ((30, 110, 60), (220, 170, 30)), "background": (50, 52, 40), "noise": 0.03}
    picture = draw_helix(R, lambda s: link, 4 * PITCH, phase=0.0, rng=1, **look)
    assert may_wind(Photo(picture.pixels)) is winds


def test_strands_too_thin_are_refused():
    picture = draw_helix(1.2, lambda s: 1 / 40, 300, rng=1)
    with pytest.raises(Unmeasurable, match="px wide"):
        helix(exact(picture))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"colours": (0, 7)}, "has 2, numbered from 0"),
        ({"colours": (1, 1)}, "two different"),
        ({"root": "left hand"}, "must be one of"),
        ({"scale": -1.0}, "must be positive"),
    ],
)
def test_wrong_options_are_named(options, message):
    with pytest.raises(Unmeasurable, match=message):
        helix(exact(drawn(turns=3)), **options)


def shapes(rng, pitch, length):
    """Link densities: even, with a step, in a wave."""
    depth, place = rng.uniform(0.02, 0.2), rng.uniform(0.3, 0.7) * length
    wave = rng.uniform(3, 8) * pitch
    return {
        "even": lambda s: 1 / pitch,
        "step": lambda s: (1 + depth * np.sign(s - place)) / pitch,
        "wave": lambda s: (1 + depth * np.sin(2 * np.pi * s / wave)) / pitch,
    }


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["even", "step", "wave"])
def test_intervals_promise_no_more_than_they_keep(shape):
    """Pooled over 15 renders of each shape at r = 4, 8 and 12 px: over 90 % of 95 % intervals hold.

    Errors are alike along one photograph, so 15 renders tell the share to some 4 %.
    """
    rng = np.random.default_rng(5)
    inside = []
    for seed in range(15):
        r = (4.0, 8.0, 12.0)[seed % 3]
        pitch = r * rng.uniform(16, 26)
        bend = rng.uniform(-0.5, 0.5)
        picture = draw_helix(
            r, shapes(rng, pitch, 5 * pitch)[shape], 5 * pitch, phase=rng.uniform(0, 6),
            heading=lambda s, b=bend, p=pitch: b * np.sin(np.pi * s / (5 * p)),
            tilt=np.radians(rng.uniform(-5, 5)), blur=rng.uniform(0.7, 1.5), rng=seed,
        )  # fmt: skip
        table = beside_truth(helix(Photo(picture.pixels)), picture)
        z = (table["link"] - table["true_link"]) / table["sd"]
        inside.append(np.mean(np.abs(z) < 1.96))
    assert np.mean(inside) > 0.90


@pytest.mark.slow
def test_intervals_hold_under_lights_unlike_the_models():
    """Twelve pictures of every kind, size and light by another renderer; lean held 64, R 33 %."""
    table = helix_unlike.measured(range(85_000, 85_012))
    held = table["error"].abs() < 1.96 * table["sd"]
    assert set(table["by"]) == {"edges"}
    assert held.groupby(table["quantity"]).mean().min() > 0.8
