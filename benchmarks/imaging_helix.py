"""Accuracy of the link density on drawn photographs whose truth is known: asked beside reached.

    python benchmarks/imaging_helix.py [RENDERS]

RENDERS (60) is the number of varied photographs for the coverage of the intervals; each is drawn,
segmented and measured from its pixels, in about 3 s on one core.
"""

import sys
import time

import numpy as np
from tqdm import tqdm

from imaging import Photo, Unmeasurable
from imaging.helix import helix
from imaging.helix_accuracy import beside_truth, total_link_error, window_errors
from imaging.helix_synthetic import Light, SyntheticHelix, draw_helix

PITCH = 18.0  # strand radii
COLOURS = (
    ((200, 40, 40), (40, 70, 190)),
    ((30, 110, 60), (220, 170, 30)),
    ((25, 25, 28), (200, 50, 40)),
    ((150, 60, 150), (60, 160, 90)),
)


def percent_rms(errors: np.ndarray) -> float:
    return 100 * float(np.sqrt(np.mean(np.square(errors))))


def uniform(r: float, **options) -> SyntheticHelix:
    turns = options.pop("turns", 20)
    sign = options.pop("sign", 1)
    pitch = PITCH * r
    return draw_helix(r, lambda s: sign / pitch, turns * pitch, rng=1, **options)


def report(what: str, asked: str, reached: str) -> None:
    print(f"{what:<58} {asked:>16} {reached:>22}", flush=True)


def uniform_helices() -> None:
    for r, asked in ((4, 0.3), (8, 0.12), (12, 0.1)):
        drawn = uniform(r)
        start = time.process_time()
        found = helix(Photo(drawn.pixels))
        seconds = time.process_time() - start
        table = beside_truth(found, drawn)
        error = percent_rms(window_errors(table, PITCH * r))
        report(f"r = {r} px: lambda per one-pitch window, RMS", f"<= {asked} %", f"{error:.4f} %")
        report(f"r = {r} px: R", "within 2 %", f"{100 * (found.R / r - 1):+.2f} %")
        link = total_link_error(table, found)
        report(f"r = {r} px: total link over 20 turns", "<= 0.1 turn", f"{link:+.4f} turn")
        report(
            f"r = {r} px: time, {drawn.pixels.shape[0]} px long, with segmenting",
            "",
            f"{seconds:.1f} s",
        )


def steps() -> None:
    for r in (4, 8, 12):
        pitch, places, errors = PITCH * r, [], []
        for phase in np.linspace(0, np.pi, 4, endpoint=False):
            drawn = draw_helix(
                r, lambda s, p=pitch, r=r: np.where(s < 8 * p, 1 / p, 1 / (24 * r)), 16 * pitch,
                phase=phase, rng=2,
            )  # fmt: skip
            table = beside_truth(helix(Photo(drawn.pixels)), drawn)
            half = 0.5 * (1 / pitch + 1 / (24 * r))
            place = float(table["true_s"][table["link"] > half].max()) - 8 * pitch
            places.append(abs(place) / pitch)
            near = (table["true_s"] - 8 * pitch).abs() < pitch
            errors.append((table["link"] / table["true_link"] - 1)[near])
        report(f"r = {r} px: step P/r 18 -> 24 located", "<= 0.5 pitch", f"{max(places):.2f} pitch")
        report(
            f"r = {r} px: lambda within a pitch of it, RMS",
            "<= 2.5 %",
            f"{percent_rms(np.concatenate(errors)):.2f} %",
        )


def hands() -> None:
    right = [
        helix(Photo(uniform(r, sign=sign, turns=5, phase=phase).pixels)).total_link * sign > 0
        for sign in (1, -1)
        for r in (4, 8)
        for phase in (0.0, 1.0, 2.0, 3.0)
    ]
    report("handedness", "always", f"{sum(right)} of {len(right)}")


def tilts() -> None:
    errors, leans = [], []
    for r in (4, 8, 12):
        for angle in (10, -10):
            drawn = uniform(r, tilt=np.radians(angle), turns=12)
            found = helix(Photo(drawn.pixels))
            errors.append(100 * abs(found.pitch / (PITCH * r) - 1))
            leans.append(np.degrees(found.lean) - angle)
    report("tilt of +-10 degrees: pitch corrected, worst", "<= 0.5 %", f"{max(errors):.2f} %")
    report("   the same uncorrected", "", f"{100 * (1 / np.cos(np.radians(10)) - 1):.2f} %")
    report("   tilt found, worst error", "", f"{max(leans, key=abs):+.2f} degrees")


def kinks() -> None:
    worst, r = 0.0, 8
    for bend in (6, 4, 3):
        for sign in (1, -1):
            drawn = kinked(r, bend, sign)
            found = helix(Photo(drawn.pixels))
            error = total_link_error(beside_truth(found, drawn), found)
            worst = max(worst, abs(error / found.total_link))
    report("kink of 90 degrees, bend radius 6, 4, 3 r: link", "within 2 %", f"{100 * worst:.3f} %")


def kinked(r: float, bend: float, sign: int) -> SyntheticHelix:
    pitch = PITCH * r

    def heading(s: np.ndarray) -> np.ndarray:
        return np.pi / 2 * np.clip((s - 5 * pitch) / (np.pi / 2 * bend * r) + 0.5, 0, 1)

    return draw_helix(r, lambda s: sign / pitch, 10 * pitch, heading=heading, phase=0.5, rng=3)


def varied(seed: int) -> SyntheticHelix:
    """Draw a photograph with everything varied: size, twist, hand, bend, light, blur, noise."""
    rng = np.random.default_rng(seed)
    r = rng.uniform(4, 10)
    pitch = r * rng.uniform(16, 30)
    length = rng.uniform(5, 8) * pitch
    depth = rng.choice([0.0, rng.uniform(0.02, 0.2)])
    place, wave = rng.uniform(0.3, 0.7) * length, rng.uniform(3, 8) * pitch
    shape = rng.choice(["wave", "step"])
    sign = rng.choice([-1, 1])
    bend = rng.uniform(-0.6, 0.6)

    def link(s: np.ndarray) -> np.ndarray:
        change = np.sin(2 * np.pi * s / wave) if shape == "wave" else np.sign(s - place)
        return sign / pitch * (1 + depth * change)

    return draw_helix(
        r, link, length,
        helix_radius=r * rng.choice([1.0, rng.uniform(1.0, 1.6)]),
        heading=lambda s: bend * np.sin(np.pi * s / length),
        phase=rng.uniform(0, 2 * np.pi),
        tilt=np.radians(rng.uniform(-5, 5)),
        colours=COLOURS[rng.integers(len(COLOURS))],
        background=tuple(rng.integers(215, 245, 3)),
        blur=rng.uniform(0.7, 1.5),
        noise=rng.uniform(0.01, 0.03),
        light=Light(direction=(rng.uniform(-0.6, 0.6), rng.uniform(-0.5, 0.2), 0.8),
                    highlight=rng.uniform(0, 0.4), uneven=rng.uniform(0, 0.4)),
        rng=rng,
    )  # fmt: skip


def coverage(renders: int) -> None:
    inside, links, refused, hands_wrong = [], [], 0, 0
    for seed in tqdm(range(renders), disable=not sys.stderr.isatty()):
        drawn = varied(seed)
        try:
            found = helix(Photo(drawn.pixels))
        except Unmeasurable:
            refused += 1
            continue
        table = beside_truth(found, drawn)
        z = (table["link"] - table["true_link"]) / table["sd"]
        inside.append(float(np.mean(np.abs(z) < 1.96)))
        links.append(total_link_error(table, found))
        hands_wrong += bool(np.sign(found.total_link) != np.sign(drawn.truth["link"].iloc[0]))
    report(
        f"95 % intervals of lambda, {renders} varied renders",
        "90 - 98 %",
        f"{100 * np.mean(inside):.1f} %",
    )
    report("   total link off by more than 0.1 turn", "0", f"{int(np.sum(np.abs(links) > 0.1))}")
    report("   handedness wrong", "0", f"{hands_wrong}")
    report("   refused", "", f"{refused}")


if __name__ == "__main__":
    report("R/r = 1, P/r = 18, blur 1 px, noise 2 %, uneven light", "asked", "reached")
    uniform_helices()
    steps()
    hands()
    tilts()
    kinks()
    coverage(int(sys.argv[1]) if len(sys.argv) > 1 else 60)
