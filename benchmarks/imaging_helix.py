"""Accuracy of the link density on drawn photographs whose truth is known: asked beside reached.

    python benchmarks/imaging_helix.py [goals] [coverage] [lab] [cables] [--renders 200]
    python benchmarks/imaging_helix.py unlike 36 [--first SEED]
    python benchmarks/imaging_helix.py combed 40 --runs RUN.nc ...

`goals`: the numbers asked of single helices. `coverage`: the share of the truth that 95 % intervals
hold, over varied photographs (`helix_renders`), each drawn, segmented and measured from its pixels.
`lab`: the photographs in data/, whose truth is a simulation, with what is found on both sides of
the tine. `cables`: twelve megapixels of cables that do not wind. `unlike N`: intervals on N
pictures by a renderer with other light (`helix_unlike`). `combed N`: both sides of the tine in N
renderings of combings that `combing simulate` left (`helix_combed`). The first three by default;
--quick draws 12 varied photographs and the smaller helices only.
"""

import argparse
import sys
import time
from functools import partial
from pathlib import Path

import helix_combed
import helix_unlike
import numpy as np
import pandas as pd
from drawn.helix import SyntheticHelix, draw_helix
from drawn.helix_accuracy import beside_truth, total_link_error, window_errors
from helix_combed import Mean
from helix_renders import COLOURS, SHAPES, is_dark, varied
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree
from tqdm import tqdm

from imaging import Photo, Unmeasurable, first_link, read_photo
from imaging.helix import helix
from imaging.helix.measurement import HelixMeasurement
from imaging.scale import from_marker

DATA = Path(__file__).parents[1] / "data"
MARKER = 0.008  # m
RADIUS = 0.425e-3  # m, of the strands in data/
GREEN = (60, 140, 60)
FIRST = 70_000  # seed; those below served to develop the method
PITCH = 18.0  # strand radii
CABLES = (  # colour, place [px] and slope
    ((190, 40, 40), 700, 0.02), ((40, 90, 190), 745, 0.02), ((70, 160, 60), 1500, -0.05),
    ((220, 190, 30), 2200, 0.1), ((45, 40, 40), 2600, 0.0),
)  # fmt: skip


def percent_rms(errors: np.ndarray) -> float:
    return 100 * float(np.sqrt(np.mean(np.square(errors))))


def uniform(r: float, **options) -> SyntheticHelix:
    turns = options.pop("turns", 20)
    sign = options.pop("sign", 1)
    pitch = PITCH * r
    return draw_helix(r, lambda s: sign / pitch, turns * pitch, rng=1, **options)


def report(what: str, asked: str, reached: str) -> None:
    print(f"{what:<58} {asked:>16} {reached:>22}", flush=True)


def uniform_helices(radii: tuple[int, ...]) -> None:
    for r, asked in ((4, 0.3), (8, 0.12), (12, 0.1)):
        if r not in radii:
            continue
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


def steps(radii: tuple[int, ...]) -> None:
    for r in radii:
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


def tilts(radii: tuple[int, ...]) -> None:
    for r in radii:
        errors, leans = [], []
        for angle in (10, -10):
            drawn = uniform(r, tilt=np.radians(angle), turns=12)
            found = helix(Photo(drawn.pixels))
            errors.append(100 * abs(found.pitch / (PITCH * r) - 1))
            leans.append(np.degrees(found.lean) - angle)
        what = f"r = {r} px: tilt of +-10 degrees"
        report(f"{what}: pitch corrected, worst", "<= 0.5 %", f"{max(errors):.2f} %")
        report(f"{what}: found, worst error", "", f"{max(leans, key=abs):+.2f} degrees")
    report("the same uncorrected", "", f"{100 * (1 / np.cos(np.radians(10)) - 1):.2f} %")


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


def splayed(r: float, phase: float = np.pi) -> SyntheticHelix:
    """Strands that part over the last pitch and a half, to four radii at their tips.

    They part in the picture where the phase at the root is pi, out of it where it is pi/2.
    """
    pitch, length = PITCH * r, 8 * PITCH * r

    def apart(s: np.ndarray) -> np.ndarray:
        return np.clip((s - (length - 1.5 * pitch)) / (1.5 * pitch), 0, 1)

    return draw_helix(
        r, lambda s: np.where(apart(s) > 0, 0.0, 1 / pitch), length,
        helix_radius=lambda s: r * (1 + 3 * apart(s) ** 2), phase=phase, rng=6,
    )  # fmt: skip


def ends_and_tines() -> None:
    r = 8
    drawn = splayed(r)
    found = helix(Photo(drawn.pixels))
    table = beside_truth(found, drawn)
    error = percent_rms(window_errors(table, PITCH * r))
    report("tips splayed over 1.5 pitches: lambda per window, RMS", "", f"{error:.3f} %")
    report("   link above them", "", f"{total_link_error(table, found):+.4f} turn")
    ways = [splayed(r, phase) for r in (4, 8) for phase in np.pi / 8 * np.arange(8)]
    links = []
    for drawn in ways:
        found = helix(Photo(drawn.pixels))
        links.append(abs(total_link_error(beside_truth(found, drawn), found)))
    reached = f"{np.median(links):.4f}, {max(links):.3f} turn"
    report("   the same in 8 directions, r = 4, 8: median, worst", "", reached)
    for name, wide in (("a third of", 1 / 6), ("0.8 of", 0.4)):
        drawn = draw_helix(
            r, lambda s: 1 / (PITCH * r), 8 * PITCH * r, tine=(4 * PITCH * r, wide * PITCH * r),
            colours=(*COLOURS[0], GREEN), rng=7,
        )  # fmt: skip
        found = helix(Photo(drawn.pixels))
        missing = total_link_error(beside_truth(found, drawn), found)
        said = any("not determined" in warning for warning in found.warnings)
        row = int((found.phase["s"] - found.tine).abs().argmin())
        place = np.interp(found.axis[row, 1], drawn.truth["y"], drawn.truth["s"])
        miss = abs(place - 4 * PITCH * r) / r
        text = f"{missing:+.3f} turn, {'said' if said else 'not said'}"
        report(f"a tine hides {name} a pitch: link; winding undetermined", "", text)
        report("   its place, not given", "", f"{miss:.2f} r")


def coverage(renders: int) -> None:
    start, rows, refused = time.process_time(), [], 0
    for seed in tqdm(range(renders), disable=not sys.stderr.isatty()):
        drawn = varied(FIRST + seed)
        try:
            found = helix(Photo(drawn.pixels))
        except Unmeasurable:
            refused += 1
            continue
        table = beside_truth(found, drawn)
        shape = SHAPES[(FIRST + seed) % len(SHAPES)]
        said = any("not determined" in warning for warning in found.warnings)
        off = not said and abs(total_link_error(table, found)) > 0.1
        if shape == "combed":  # whose density falls towards its very end
            table = table[table["true_s"] < drawn.truth["s"].iloc[-1] - found.pitch]
        z = (table["link"] - table["true_link"]) / table["sd"]
        hand = np.sign(found.total_link) == np.sign(drawn.truth["link"].median())
        rows.append({
            "shape": shape,
            "cloth": "dark" if is_dark(FIRST + seed) else "light",
            "inside": float(np.mean(np.abs(z) < 1.96)),
            "rms": percent_rms(table["link"] / table["true_link"] - 1),
            "off": off,
            "wrong": not hand,
        })  # fmt: skip
    found = pd.DataFrame(rows)
    share = 100 * found["inside"].mean()
    error = 100 * found["inside"].std() / np.sqrt(len(found))
    what = f"95 % intervals of lambda, {renders} varied renders"
    report(what, "90 - 98 %", f"{share:.1f} +- {error:.1f} %")
    for (shape, cloth), group in found.groupby(["shape", "cloth"]):
        text = f"{100 * group['inside'].mean():.1f} %, RMS {group['rms'].median():.2f} %"
        report(f"   {shape}, {cloth} cloth: held; typical error of a point", "", text)
    report("   total link off by more than 0.1 turn, not said", "0", f"{found['off'].sum()}")
    report("   handedness wrong", "0", f"{found['wrong'].sum()}")
    report("   refused", "", f"{refused}")
    seconds = (time.process_time() - start) / renders
    report("   processor time to draw and measure one", "", f"{seconds:.1f} s")


def lab() -> None:
    """Photographs of the virtual lab beside the simulated strands, at the same picture points."""
    strands, first = np.load(DATA / "truth" / "synthetic_strands.npz"), None
    photos = (DATA / "photos").glob("synthetic_helix_*.jpg")
    for path in sorted(photos, key=lambda p: (not p.stem.endswith("before"), p.stem)):
        scale, photo = from_marker(read_photo(path), MARKER)
        start = time.process_time()
        found = helix(photo, scale=scale)
        seconds = time.process_time() - start
        truth = seen_truth([strands[f"{path.stem}/{k}"] for k in (1, 2)], photo)
        name = path.stem.removeprefix("synthetic_")
        _report_lab(name, found, truth, seconds)
        first = first or (first_link(found), helix_combed.link_in_space(truth))
        _report_sides(name, found, truth, *first)


def _report_sides(name: str, found: HelixMeasurement, truth: pd.DataFrame, *rest: Mean) -> None:
    """Print lambda_0, or what is found on both sides of the tine, over lambda_0."""
    seen, exact = rest
    if found.tine is None:
        text = f"{seen[0]:.2f} +- {seen[1]:.2f} 1/m, of the strands {exact[0]:.2f}"
        report(f"{name}: lambda_0", "", text)
        return
    table = helix_combed.errors(found, truth, seen, exact)
    shares = {what: percent_rms(one["error"]) for what, one in table.groupby("what")}
    text = f"{shares['behind']:.1f} %, {shares['ahead']:.1f} %"
    report(f"{name}: lambda over a pitch, RMS behind, ahead", "10 %, 1 or 3 %", text)
    jump = table[table["what"] == "jump"].iloc[0]
    text = f"{jump['error']:+.2f} +- {jump['sd']:.2f}, {found.phase['resolved'].mean():.0%}"
    report(f"{name}: error of the jump over lambda_0; resolved", "0.06; 90 %", text)


def _report_lab(name: str, found: HelixMeasurement, truth: pd.DataFrame, seconds: float) -> None:
    known = found.phase["by"].to_numpy() == "edges"
    nearest = cKDTree(truth[["x", "y"]]).query(found.axis[known])[1]
    # The true density falls where the strands end; the last pitch of the photograph is left out.
    inner = (truth["s"].to_numpy() < truth["s"].iloc[-1] - found.pitch)[nearest]
    link = found.link_density[known][inner]
    error = (link["link"] - truth["link"].to_numpy()[nearest][inner]).to_numpy()
    held = 100 * np.mean(np.abs(error) < 1.96 * link["sd"])
    rms = float(np.sqrt(np.mean(error**2)))
    ahead = found.phase["s"] > (found.tine or 0.0)
    typical, share = float(np.median(np.abs(error))), 100 * known[ahead].mean()
    text = f"{rms:5.2f} {typical:5.2f} 1/m {held:3.0f} % {share:3.0f} %"
    report(f"{name} ({seconds:.1f} s): RMS, median error, held, resolved ahead", "", text)


def seen_truth(strands: list[np.ndarray], photo: Photo) -> pd.DataFrame:
    """Link density (s, link) of strands in space and where the photograph shows it (x, y)."""
    from combing.camera import project
    from combing.virtual_lab.helix_photos import PIXELS_PER_RADIUS
    from combing.virtual_lab.photographs import broadside, frame, smooth

    a, b = (smooth(strand) for strand in strands)
    views = (broadside([a, b]), np.array([0.0, 1, 0]), np.array([1.0, 0, 0]))
    pixel = RADIUS / PIXELS_PER_RADIUS
    cameras = [frame([a, b], q * view, pixel) for view in views for q in (1, -1)]
    fitting = [c for c in cameras if (c.size[1], c.size[0]) == photo.shape]
    truths = [helix_combed.truth_in([a, b], partial(project, camera=c)) for c in fitting]
    return max(truths, key=lambda truth: _bright(photo, truth[["x", "y"]].to_numpy()))


def _bright(photo: Photo, points: np.ndarray) -> float:
    """Mean brightness at picture points; strands are brighter than the cloth behind them."""
    x, y = np.clip(np.rint(points.T), 0, np.array(photo.shape[::-1])[:, None] - 1).astype(int)
    return float(photo.rgb()[y, x].mean())


def cables() -> np.ndarray:
    """Five straight cables on card (3000, 4000, 3), two of them touching, with soft shadows."""
    rng, (y, x) = np.random.default_rng(2), np.mgrid[:3000, :4000].astype(np.float32)
    picture = np.full((*y.shape, 3), (226, 222, 214), np.float32)
    for colour, place, slope in CABLES:
        off = (y - place - slope * (x - 2000)) / 22
        shadow = 0.25 * np.clip(1.6 - np.abs(off - 0.6), 0, 1)
        picture *= (1 - shadow * (np.abs(off) > 1))[..., None]
        lit = 0.45 + 0.55 * np.sqrt(np.clip(1 - off**2, 0, 1))
        picture = np.where((np.abs(off) < 1)[..., None], lit[..., None] * colour, picture)
    picture = gaussian_filter(picture, (1.2, 1.2, 0)) * (1 - 0.2 * x / 4000)[..., None]
    return np.clip(picture + rng.normal(0, 3, picture.shape), 0, 255).astype(np.uint8)


def refusal() -> None:
    picture = Photo(cables())
    for call in ("first", "second"):
        start = time.process_time()
        try:
            said = f"link {helix(picture, root='left').total_link:.1f}"
        except Unmeasurable:
            said = "refused"
        seconds = time.process_time() - start
        report(
            f"12 megapixels of straight cables, {call} call", "<= 2 s", f"{said}, {seconds:.1f} s"
        )


def goals(quick: bool) -> None:
    radii = (4, 8) if quick else (4, 8, 12)
    report("R/r = 1, P/r = 18, blur 1 px, noise 2 %, uneven light", "asked", "reached")
    for by_radius in (uniform_helices, steps, tilts):
        by_radius(radii)
    for check in (hands, kinks, ends_and_tines):
        check()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART, as above")
    parser.add_argument("--renders", type=int, default=200)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--first", type=int, help="first seed of `unlike` or `combed`")
    parser.add_argument("--runs", nargs="+", type=Path, default=[], help="runs for `combed`")
    asked = parser.parse_args()
    parts = asked.parts or ["goals", "coverage", "lab"]
    if "goals" in parts:
        goals(asked.quick)
    if "coverage" in parts:
        coverage(12 if asked.quick else asked.renders)
    if "lab" in parts:
        lab()
    if "cables" in parts:
        refusal()
    count = next((int(part) for part in parts if part.isdigit()), 40)
    if "unlike" in parts:
        helix_unlike.main(count, asked.first or helix_unlike.FIRST)
    if "combed" in parts:
        helix_combed.main(asked.runs, count, asked.first or helix_combed.FIRST)


if __name__ == "__main__":
    main()
