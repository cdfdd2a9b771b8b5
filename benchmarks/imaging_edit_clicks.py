"""Clicks on the page of `combing edit` until drawn curls of twelve hairs of one colour are right.

Run from the checkout (needs Chromium):

    python benchmarks/imaging_edit_clicks.py [SEED ...] [--folder FOLDER]

A made-up user who knows the truth clicks the real page in a browser, and does at each turn what
gains most length of the right strands for a click: exchange two strands where they touch (a click
and a key), or draw a strand anew (a click where the live wire must be held, two at its end), or
delete what is none. He sees the wire before he clicks, as anybody does. What he saves is then
applied by the program; strands and N-body table are those of `imaging.measure`.
"""

import argparse
import json
import tempfile
from pathlib import Path

import browser
import cv2
import numpy as np
import pandas as pd
from imaging_curls import counts, draw, right
from scipy.spatial import cKDTree

import imaging
from combing.commands.edit import PAGE
from imaging.correct import Corrections
from imaging.correct.schema import parse_corrections
from imaging.edit import edit_page
from imaging.report.overlay import as_jpeg, draw_overlay
from imaging.trace.centreline import resample

REAL = Path(__file__).parents[2] / "shared" / "real"  # beside the checkout; CC0
PAIR = [(134, 262, "shift"), (298, 312, "shift"), (463, 403, "shift"), (627, 490, "shift"),
        (792, 555, "shift")]  # fmt: skip
SESSIONS: dict[str, list] = {  # what a person clicked who looked at the page: places [px] and keys
    "cc0/two_singles.jpg": [(2, 420), "x"],
    "ply/two_pairs.jpg": [
        (300, 310), "x", (350, 240), "x", (330, 230), "x",
        "d", (20, 252), *PAIR, (868, 610), "Enter", "d", (22, 268), *PAIR, (912, 605), "Enter",
    ],
}  # fmt: skip
NEAR = 4.0  # px from the truth, for what is on the page
STEP = 40  # px ahead at which the wire is looked at
WORTH = 60.0  # px of right strands that a click must gain


class User:
    """Who knows the truth and clicks until the page shows it."""

    def __init__(self, page: browser.Page, truth: list[np.ndarray]) -> None:
        self.page, self.truth = page, [resample(line) for line in truth]
        self.trees = [cKDTree(line) for line in self.truth]

    def work(self) -> None:
        while self.exchange():
            pass
        for number in self.wrong(self.lines()):
            self.draw_one(number)
        self.delete_others()

    def lines(self, steps: str = "said.steps") -> list[np.ndarray]:
        """Strands of the page, points a pixel apart."""
        found = self.page.value(
            f"JSON.stringify(replay(measured, {steps}).strands.map((s) => s.line))"
        )
        return [resample(np.array(line)) for line in json.loads(found)]

    def gained(self, lines: list[np.ndarray]) -> float:
        """Length of the truth that one strand follows at a stretch, summed over the truth."""
        return sum(self.followed(number, lines) for number in range(len(self.truth)))

    def followed(self, number: int, lines: list[np.ndarray]) -> int:
        return max((longest(self.trees[number].query(line)[0] < NEAR) for line in lines), default=0)

    def wrong(self, lines: list[np.ndarray]) -> list[int]:
        length = [len(line) for line in self.truth]
        return [n for n in range(len(length)) if self.followed(n, lines) < 0.95 * length[n]]

    def exchange(self) -> bool:
        """Exchange two strands where it gains most; False where none is worth a click."""
        before, best, place = self.gained(self.lines()), WORTH, None
        for x, y in self.changes():
            said = f"(() => {{ const t = thingAt([{x}, {y}]); const step = t && exchangeAt(t);"
            step = self.page.value(said + "return step ? JSON.stringify(step) : null; })()")
            if step is not None:
                gain = self.gained(self.lines(f"[...said.steps, {step}]")) - before
                if gain > best:
                    best, place = gain, (x, y)
        if place is None:
            return False
        self.page.click(*place)
        self.page.key("e")
        return True

    def changes(self) -> list[tuple[float, float]]:
        """Where a strand of the page goes over from one true strand to another."""
        places = []
        for line in self.lines():
            far = np.array([tree.query(line)[0] for tree in self.trees])
            at = 0
            while at < len(line):
                ahead = [first(row[at:] >= NEAR) for row in far]
                if at and max(ahead) > 20:
                    places.append(tuple(line[at].tolist()))
                at += max(*ahead, 5)
        return places

    def draw_one(self, number: int) -> None:
        """Draw a true strand anew."""
        line, at = self.truth[number], 0
        self.page.key("d")
        self.page.click(*line[0])
        while at < len(line) - 1:
            at = self.farthest(line, at)
            self.page.click(*line[at])
        self.page.click(*line[-1])

    def farthest(self, line: np.ndarray, at: int) -> int:
        """Farthest point of a line to which the wire leads along it, looking so far ahead."""
        best = ahead = min(at + STEP, len(line) - 1)
        while ahead <= best + 3 * STEP and ahead < len(line):
            wire = self.page.value(f"JSON.stringify(wire.to({line[ahead].tolist()}))")
            off = cKDTree(line[at : ahead + 1]).query(resample(np.array(json.loads(wire))))[0]
            if (off < NEAR).mean() > 0.98:
                best = ahead
            if ahead == len(line) - 1:
                break
            ahead = min(ahead + STEP, len(line) - 1)
        return best

    def delete_others(self) -> None:
        """Delete strands that follow no true one, and second ones that do, but for what he drew."""
        taken = set()
        drawn = json.loads(self.page.value("JSON.stringify(state.strands.map((s) => s.by))"))
        for number, line in reversed(list(enumerate(self.lines()))):
            share = [(tree.query(line)[0] < NEAR).mean() for tree in self.trees]
            owner = int(np.argmax(share))
            good = share[owner] > 0.9 and len(line) > 0.9 * len(self.truth[owner])
            if drawn[number] != "drawn" and (not good or owner in taken):
                self.page.click(*self.alone(number))
                self.page.key("x")
            taken |= {owner} if good else set()

    def alone(self, number: int) -> tuple[float, float]:
        """Where a strand lies farthest from all others, to be clicked there."""
        lines = self.lines()
        others = np.concatenate([line for n, line in enumerate(lines) if n != number])
        far = cKDTree(others).query(lines[number])[0]
        return tuple(lines[number][int(far.argmax())].tolist())


def longest(good: np.ndarray) -> int:
    """Length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def first(bad: np.ndarray) -> int:
    """Index of the first True, or the length."""
    return int(bad.argmax()) if bad.any() else len(bad)


def score(seed: int, folder: Path, page: browser.Page) -> dict[str, object]:
    curl = draw(seed, one_colour=True)
    photo = imaging.Photo(curl.pixels, f"{seed}.png")
    found = imaging.measure(photo, corrections=None)
    file = folder / f"{seed}{PAGE}"
    file.write_text(edit_page(photo, found, Corrections()), encoding="utf-8")
    cv2.imwrite(str(folder / f"{seed}.png"), curl.pixels[..., ::-1])
    page.open(file, 1500, 1300)
    page.clicks = page.keys = 0
    User(page, curl.lines).work()
    said = parse_corrections(page.value("fileText()"), file.name)
    page.picture(folder / f"{seed}.page.png")
    after = imaging.measure(photo, corrections=said)
    number = imaging.measure(photo, corrections=Corrections(strands=len(curl.lines)))
    true = imaging.interactions(curl.lines)
    return {
        "seed": seed, "right, unaided": right_of(curl, found),
        "--strands 12": right_of(curl, number), "corrected": right_of(curl, after),
        "clicks": page.clicks, "keys": page.keys,
        "steps": pd.Series([step.do for step in said.steps]).value_counts().to_dict(),
        "misfits": after.hand.tally().get("no longer fits", 0),
        "N = 2, 3, 4 true": counts(true), "unaided": counts(found.interactions),
        "by hand": counts(after.interactions), "complaints": page.complaints,
    }  # fmt: skip


def session(name: str, folder: Path, page: browser.Page) -> dict[str, object]:
    """Repeat what a person clicked on a real photograph."""
    photo = imaging.read_photo(REAL / name)
    found = imaging.measure(photo, corrections=None)
    file = folder / f"{Path(name).name}{PAGE}"
    file.write_text(edit_page(photo, found, Corrections()), encoding="utf-8")
    page.open(file, 1500, 1300)
    page.clicks = page.keys = 0
    for act in SESSIONS[name]:
        if isinstance(act, str):
            page.key(act)
        else:
            page.click(*act[:2], shift=len(act) == 3)
    said = parse_corrections(page.value("fileText()"), file.name)
    page.picture(folder / f"{Path(name).stem}.page.png")
    after = imaging.measure(photo, corrections=said)
    overlay = draw_overlay(
        photo, after.segmentation, after.strands, after.crossings, after.unresolved
    )
    (folder / f"{Path(name).stem}.after.jpg").write_bytes(as_jpeg(overlay))
    return {
        "photo": name, "strands, unaided": len(found.strands), "corrected": len(after.strands),
        "clicks": page.clicks, "keys": page.keys, "outcomes": after.hand.tally(),
        "by": after.hand.by, "complaints": page.complaints,
    }  # fmt: skip


def right_of(curl, found: imaging.Measured) -> str:
    return f"{sum(right(line, found.strands) for line in curl.lines)}/{len(found.strands)}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seeds", type=int, nargs="*", default=[1012, 1013, 1014])
    parser.add_argument("--folder", type=Path, help="keep pages and pictures there")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as kept:
        folder = asked.folder or Path(kept)
        folder.mkdir(parents=True, exist_ok=True)
        with browser.page(folder) as page:
            for name in SESSIONS if REAL.exists() else ():
                print(json.dumps(session(name, folder, page)), flush=True)
            for seed in asked.seeds:
                print(json.dumps(score(seed, folder, page)), flush=True)


if __name__ == "__main__":
    main()
