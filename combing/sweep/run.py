"""Simulate the points of a sweep that a folder does not hold yet."""

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import numpy as np
import pandas as pd

import instron
import sim
from combing.ensemble import Member
from combing.errors import UserError
from combing.progress import Bar
from combing.runs import scaled
from combing.study.plan import Sweep, second
from combing.sweep.store import Store, part_of_points
from combing.tables import write_table
from combing.tolerance.errors import apart
from combing.workers import Crew, cores

ERRORS = ("force_error", "link_error")  # of a verified point, as shares
BUSY = "another process is writing this run"  # sim.records.journal's words: no failure


class Engine(Protocol):
    """What simulates scenes into files: `combing.workers.Crew`, or a cluster."""

    @property
    def fraction(self) -> float: ...  # noqa: D102

    def wait(  # noqa: D102
        self, look: Callable[[], None], ended: Callable[[Path, Exception | None], None]
    ) -> None: ...

    def stop(self) -> None: ...  # noqa: D102

    def dismiss(self) -> None: ...  # noqa: D102


Start = Callable[[Mapping[Path, sim.Scene]], Engine]


def run_sweep(
    sweep: Sweep,
    out: Path,
    *,
    part: tuple[int, int] = (1, 1),
    jobs: int | None = None,
    retry: bool = False,
    quiet: bool = False,
    start: Start | None = None,
) -> pd.DataFrame:
    """Simulate what is missing of a sweep, or of a part of it, and write ``points.csv``.

    Parameters
    ----------
    sweep : Sweep
        From `load_sweep`.
    out : Path
        Folder of the points.
    part : (int, int)
        Simulate the i-th of n parts of the points and write ``points_{i}of{n}.csv``; several parts
        may run at once. A call for the whole, once all are done, writes the table of all.
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    retry : bool
        Simulate also points whose motion became unstable before.
    quiet : bool
        Show no progress.
    start : callable, optional
        Starts another engine than processes on this machine.

    Returns
    -------
    DataFrame
        One row a point: the varied parameters, seed, state (done, failed,
        missing), f_max, D [m], w, reason, file; with a tolerance force_error, link_error and held,
        of the first member of every point.

    Raises
    ------
    UserError
        The folder cannot be written to.
    """
    mine, store = part_of_points(sweep.members(), part), Store(out)
    seconds = {} if sweep.tolerance is None else seconds_of(mine)
    wanted = [*mine, *seconds.values()]
    simulate_points(wanted, store, jobs=jobs, retry=retry, quiet=quiet, start=start)
    table = store.table(mine, sweep.varied)  # of the others it would be n times the whole's reading
    if sweep.tolerance is not None:
        errors = [_errors(one, seconds.get(k), store) for k, one in enumerate(mine)]
        table = table.join(pd.DataFrame(errors, columns=list(ERRORS)))
        worst = table[list(ERRORS)].max(axis=1)
        said = np.where(worst <= sweep.tolerance, "yes", "no")
        table["held"] = np.where(worst.notna(), said, "")
    about = f"{sweep.title}: {sweep.preset}; f_max and w scaled by l0 = 0.01 m, D in m"
    write_table(out / table_name(part), table, [about])
    return table


def seconds_of(mine: Sequence[Member]) -> dict[int, Member]:
    """Return, by its number, what verifies the first member of every point."""
    first: dict[str, int] = {}
    for k, one in enumerate(mine):
        first.setdefault(json.dumps(dict(one.parameters), sort_keys=True), k)
    return {k: second(mine[k]) for k in first.values()}


def _errors(member: Member, other: Member | None, store: Store) -> dict[str, float]:
    """Return how far a member is off its verification, from disk if it was compared before."""
    if other is None or not (store.path(member).exists() and store.path(other).exists()):
        return {}
    known = store.results(other) or {}
    if ERRORS[0] not in known:
        with suppress(UserError):  # no curve before the first release: there is nothing to hold
            runs = (sim.open_run(store.path(one)) for one in (other, member))
            known = known | dict(zip(ERRORS, apart(*runs), strict=True))
            store.succeed(other, known)
    return {key: known[key] for key in ERRORS if key in known}


def table_name(part: tuple[int, int]) -> str:
    """Return the name of the table of a part; the only part is the whole."""
    number, parts = part
    return "points.csv" if parts == 1 else f"points_{number}of{parts}.csv"


def simulate_points(
    members: Sequence[Member],
    store: Store,
    *,
    jobs: int | None = None,
    retry: bool = False,
    quiet: bool = False,
    start: Start | None = None,
) -> None:
    """Simulate the members that a store does not hold; what fails is recorded and not raised."""
    store.prepare()
    missing = store.missing(members, retry=retry)
    for member in missing.values():
        store.describe(member)
    if missing:
        scenes = {path: member.scene for path, member in missing.items()}
        engine = (start or _processes(jobs))(scenes)
        try:
            _watch(engine, missing, store, quiet)
        except BaseException:
            engine.stop()
            raise
        engine.dismiss()
    for member in members:
        if store.path(member).exists() and store.results(member) is None:
            store.succeed(member, measured(sim.open_run(store.path(member))))


def measured(run: sim.Run) -> dict[str, float]:
    """Return f_max, D [m] and w of a combing by the rules of `instron.scale`; nothing of a curl."""
    if not run.scene.tines:
        return {}
    try:
        facts = scaled(run).attrs
    except instron.Unscalable:
        return {}
    return {key: float(facts[key]) for key in ("f_max", "D", "w")}


def _processes(jobs: int | None) -> Start:
    def start(scenes: Mapping[Path, sim.Scene]) -> Crew:
        return Crew(scenes, min(len(scenes), jobs or cores()))

    return start


def _watch(engine: Engine, missing: Mapping[Path, Member], store: Store, quiet: bool) -> None:
    done = failed = 0
    with Bar(total=100.0, mininterval=1, disable=quiet) as bar:

        def look() -> None:
            ending = f", {failed} failed" if failed else ""
            bar.set_description(f"{done + failed} of {len(missing)} points{ending}", refresh=False)
            bar.update(100 * engine.fraction - bar.n)

        def ended(path: Path, error: Exception | None) -> None:
            nonlocal done, failed
            if error is None:
                done += 1
                store.succeed(missing[path], measured(sim.open_run(path)))
                return
            failed += 1
            if BUSY not in str(error):
                with suppress(OSError):  # on a full disk: it is tried again the next time anyway
                    store.fail(missing[path], error)

        look()
        engine.wait(look, ended)
        look()
