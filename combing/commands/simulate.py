"""``combing simulate``: run a scene, write the run, its tables and a picture."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import pandas as pd

from combing.errors import UserError
from combing.progress import Bar
from combing.spoken import said_aloud

if TYPE_CHECKING:
    from sim import Run, Scene


@click.command()
@click.argument("scene", required=False, type=click.Path(path_type=Path))
@click.option("--preset", help="double_helix or curl, instead of a scene file.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="A preset's parameter.")
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              default=Path("combing-run"), show_default=True,
              help="Folder for all that is written.")  # fmt: skip
@click.option("--snapshots", type=int, help="Strands recorded this many times.")
@click.option("--seed", type=int, help="Another draw of what is random in the scene.")
@click.option("--rest", is_flag=True, help="End at rest; the scene's duration is then the longest.")
@click.option("--tolerance", metavar="ERROR", help="2%, draft, standard or fine: choose the mesh, "
              "step, speed of the tine and stiffness that hold it, and verify them.")  # fmt: skip
@click.option("--error-bars", is_flag=True, help="Give all numbers and curves a band at 95 %.")
@click.option("--members", type=click.IntRange(min=2), default=5, show_default=True,
              help="Perturbed runs behind the error bars.")  # fmt: skip
@click.option("--fresh", is_flag=True, help="Begin anew, also over another or unfinished run.")
@click.option("--any-cost", is_flag=True, help="Begin also what would take more than a week.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--quiet", is_flag=True, help="No progress and no summary.")
def command(
    scene: Path | None,
    preset: str | None,
    settings: tuple[str, ...],
    output: Path,
    snapshots: int | None,
    seed: int | None,
    rest: bool,
    tolerance: str | None,
    error_bars: bool,
    members: int,
    fresh: bool,
    any_cost: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Simulate a SCENE and write what was recorded.

    SCENE is a TOML file: a preset with its parameters, or rods, contact, friction, damping, tines
    one by one (docs/sim.md lists the keys). Units are SI.

    \b
    Example:
      combing simulate --preset double_helix --set pi1=18 --set height=0.06 -o out/
      combing simulate scene.toml -o out/
    where scene.toml holds, say:
      preset = "double_helix"
      pi1 = 18                  # pitch over filament radius
      height = 0.15             # m
      friction = 0.2            # Coulomb's mu; leave out for none

    \b
    Presets and their parameters (lengths in m, speed in m/s, E in Pa):
      double_helix  two strands clamped at the top, combed by a tine:
                    pi1 = P/r, pi2 = R/r, pi3 = t/r, handedness, r, height or turns,
                    q (pitches below the tine), friction, speed, insertion, E, nu, density,
                    elements_per_pitch, imperfection, samples_per_pitch,
                    snapshots, seed, forces, frames
      curl          n hairs that hang until they rest, or a duration, no tine:
                    n, length, r, curvature, correlation, spread, friction,
                    E, nu, density, elements, duration, until, snapshots, seed,
                    forces, frames

    \b
    Written into the output folder:
      run.nc        everything, with units (NetCDF: Python, MATLAB, ParaView)
      force.csv     time, displacement, force on the tine; for combing force
      link.csv      link density of a pair of strands at every snapshot
      strands.csv   nodes of every strand at every snapshot
      numbers.csv, band_force.csv, band_link.csv   with --error-bars; also in run.nc
      run.png, .svg strands, force and link density at a glance

    double_helix at its defaults takes one to two minutes on one core; time grows as the number of
    elements and of steps, and steps get shorter with r and with the length of an element. A bar
    shows the time left; the first run of its kind on a machine compiles for up to a minute before.
    Ctrl-C, a crash or a power cut cost at most 30 s of work: the same command goes on from
    run.nc.part in the output folder.

    \b
    --tolerance 2% takes the cheapest elements a pitch, step, speed of the tine and stiffness of
    contact that were measured to hold f (over the highest f) and lambda (over 1/P) within 2 % up to
    the first release, runs them beside a second setting of twice the error to verify it, refines
    where that fails, and says what it cost and what half the error would. draft is 10 %, standard
    3 %, fine 1.5 %; for helices that one tine combs:
      combing simulate --preset double_helix --set height=0.04 --tolerance 2% -o out/

    \b
    --error-bars also simulates the scene on a mesh of two thirds of the elements, and MEMBERS times
    with a random curvature of 2 % in every strand, on all cores (kept in the folder runs). f and
    lambda then have a band at 95 %: up to the first release where an infinitely fine mesh would be,
    beyond it, like f_max, D, w and rho_N, where one more such specimen would be. A pair and five
    members take seven times as long, on two cores half of that:
      combing simulate --preset double_helix --set height=0.04 --error-bars -o out/
    """
    if rest and preset == "curl":  # which takes longer to rest than it takes otherwise
        settings = ("until=rest", *settings)
    made = _scene(scene, preset, settings, {"snapshots": snapshots, "seed": seed})
    if rest:
        made = made.model_copy(update={"until": "rest"})
    silent = quiet or as_json
    if tolerance is not None or error_bars:
        run = _run_accurately(
            made, output, tolerance, members * error_bars,
            fresh=fresh, quiet=silent, any_cost=any_cost,
        )  # fmt: skip
    else:
        run = _run(made, output, silent, fresh=fresh, any_cost=any_cost)
    summary = _write(run, output)
    if as_json:
        click.echo(json.dumps(summary, indent=1))
    elif not quiet:
        click.echo("\n".join(f"{key}: {value}" for key, value in summary.items()))


def _scene(
    path: Path | None,
    preset: str | None,
    settings: tuple[str, ...],
    overrides: dict[str, int | None],
) -> Scene:
    from sim import load_scene
    from sim.scene.presets import preset_scene

    if (path is None) == (preset is None):
        raise UserError(
            "give a scene file or --preset double_helix or --preset curl, one of the two"
        )
    if path is None:
        given = {key: value for key, value in overrides.items() if value is not None}
        return preset_scene(str(preset), dict(_parameter(text) for text in settings) | given)
    if settings:
        raise UserError(f"--set {settings[0]}: goes with --preset; write it into {path} instead")
    return load_scene(path, **overrides)


def _parameter(text: str) -> tuple[str, Any]:
    key, separator, value = text.partition("=")
    if not separator:
        raise UserError(f"--set {text}: expected KEY=VALUE, for example --set pi1=18")
    try:
        return key, json.loads(value)
    except json.JSONDecodeError:
        return key, value


def _run(scene: Scene, output: Path, quiet: bool, *, fresh: bool, any_cost: bool) -> Run:
    from sim import simulate

    bar = Bar(
        total=100, desc=scene.title, disable=quiet, delay=1e-3,
        mininterval=0.5 if sys.stderr.isatty() else 30.0,  # a log file needs few lines
    )  # fmt: skip

    def progress(done: float) -> None:
        if bar.n == 0:  # compiling, or an earlier part of this run, tells nothing of the time left
            bar.reset()
            bar.initial = 100 * done
        bar.update(100 * done - bar.n)

    with said_aloud("sim", quiet=quiet), bar:
        try:
            return simulate(
                scene, output / "run.nc", progress=progress, resume=not fresh, any_cost=any_cost
            )
        except KeyboardInterrupt:
            bar.close()
            click.echo(f"stopped; {_how_to_go_on(output)}", err=True)
            raise


def _run_accurately(
    scene: Scene, output: Path, tolerance: str | None, members: int, *, fresh: bool, **how: bool
) -> Run:
    """Simulate to a tolerance if there is one, then with error bars if there are members."""
    from combing.bands import simulate_with_bands
    from combing.tolerance import as_tolerance, read_tolerance, simulate_to_tolerance, with_record

    path = output / "run.nc"
    record = None
    with said_aloud("combing", quiet=how["quiet"]):
        try:
            if tolerance is not None:
                asked = as_tolerance(tolerance)
                run = simulate_to_tolerance(scene, path, asked, fresh=fresh, **how)
                scene, record, fresh = run.scene, read_tolerance(run), True
            if members:
                run = simulate_with_bands(scene, path, members=members, fresh=fresh, **how)
        except KeyboardInterrupt:
            click.echo(f"stopped; the same command goes on from {output / 'runs'}", err=True)
            raise
    if record is not None and members:
        run = with_record(run, record)
        run.save(path)
    return run


def _how_to_go_on(output: Path) -> str:
    if not (output / "run.nc.part" / "checkpoint.npz").exists():
        return "there is no checkpoint yet, the same command begins anew"
    return f"the same command goes on from {output / 'run.nc.part'}, --fresh begins anew"


def _write(run: Run, output: Path) -> dict[str, Any]:
    """Write tables and picture beside the run and return the numbers of interest."""
    from combing.bands import read_bands
    from combing.figures.run import draw_run
    from combing.figures.style import save
    from combing.tables import write_table
    from combing.tolerance import in_words, read_tolerance

    links, bands = _links(run), read_bands(run)
    log = run.force_log() if run.scene.tines else None
    write_table(output / "strands.csv", _strands(run), ["positions at every snapshot, metres"])
    if links is not None:
        write_table(output / "link.csv", links, ["link density [1/m] at every snapshot"])
    if log is not None:
        write_table(
            output / "force.csv", log, ["time [s], displacement [m], force on the tine [N]"]
        )
    if bands is not None:
        bands.write(output)
    save(draw_run(run, log, links, bands), output, "run", synthetic=False)
    summary = _summary(run, log, links)
    if record := read_tolerance(run):
        summary |= in_words(record)
    return summary | (bands.said() if bands else {}) | {"written to": str(output)}


def _links(run: Run) -> pd.DataFrame | None:
    """Return the link density of a pair at every snapshot, None for any other number of rods."""
    from sim import link_density

    if len(run.scene.rods) != 2:
        return None
    tables = [
        link_density(*run.strands(i)).assign(snapshot=i, displacement=d)
        for i, d in enumerate(run.displacements)
    ]
    return pd.concat(tables, ignore_index=True)


def _turns(run: Run, snapshot: int) -> float:
    from sim import link_density

    return round(link_density(*run.strands(snapshot)).attrs["total_link"], 3)


def _strands(run: Run) -> pd.DataFrame:
    tables = [
        pd.DataFrame(strand, columns=["x", "y", "z"]).assign(strand=number, snapshot=i, time=time)
        for i, time in enumerate(run.times)
        for number, strand in enumerate(run.strands(i))
    ]
    return pd.concat(tables, ignore_index=True)


def _summary(run: Run, log: pd.DataFrame | None, links: pd.DataFrame | None) -> dict[str, Any]:
    about = run.data.attrs
    summary: dict[str, Any] = {
        "scene": about["title"],
        "march": about["march"],
        "time step [s]": float(f"{about['time_step_s']:.4g}"),
        "stability limit [s]": float(f"{about['stability_limit_s']:.4g}"),
        "steps": int(about["steps"]),
        "wall time [s]": round(float(about["wall_time_s"]), 1),
    }
    if log is not None:
        peak = log.iloc[int(log["force"].to_numpy().argmax())]
        summary["largest force [N]"] = float(f"{peak['force']:.4g}")
        summary["at displacement [mm]"] = float(f"{1e3 * peak['displacement']:.4g}")
    if links is not None:
        summary["link at the start and the end"] = [_turns(run, 0), _turns(run, -1)]
    if not run.scene.tines:
        force, speed = (float(run.data[f"snapshot_{of}"][-1]) for of in ("imbalance", "speed"))
        summary["largest net force at the end [node weights]"] = float(f"{force:.2g}")
        summary["largest speed at the end [m/s]"] = float(f"{speed:.2g}")
        summary["rest"] = about.get("rest", run.unrest() or "at rest")
    return summary
