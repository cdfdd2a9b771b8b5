"""``combing simulate``: run a scene, write the run, its tables and a picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import pandas as pd
from tqdm import tqdm

from combing.errors import UserError

if TYPE_CHECKING:
    from sim import Run, Scene

HELP_OUTPUT = "Folder for run.nc, force.csv, link.csv, strands.csv, run.png and run.svg."


@click.command()
@click.argument("scene", required=False, type=click.Path(path_type=Path))
@click.option("--preset", help="double_helix or curl, instead of a scene file.")
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE", help="A preset's parameter.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("combing-run"),
              show_default=True, help=HELP_OUTPUT)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--quiet", is_flag=True, help="No progress bar and no summary.")
def command(
    scene: Path | None,
    preset: str | None,
    settings: tuple[str, ...],
    output: Path,
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
      preset = "double_helix"   # or "curl"
      pi1 = 18                  # pitch over filament radius
      height = 0.15             # m
      friction = 0.2            # Coulomb's mu; leave out for none
    """
    run = _run(_scene(scene, preset, settings), output, quiet or as_json)
    summary = _write(run, output)
    if as_json:
        click.echo(json.dumps(summary, indent=1))
    elif not quiet:
        click.echo("\n".join(f"{key}: {value}" for key, value in summary.items()))


def _scene(path: Path | None, preset: str | None, settings: tuple[str, ...]) -> Scene:
    from sim import load_scene
    from sim.presets import preset_scene

    if (path is None) == (preset is None):
        raise UserError("give a scene file or --preset, one of the two")
    if path is None:
        return preset_scene(str(preset), dict(_parameter(text) for text in settings))
    if settings:
        raise UserError(f"--set {settings[0]}: goes with --preset; write it into {path} instead")
    return load_scene(path)


def _parameter(text: str) -> tuple[str, Any]:
    key, separator, value = text.partition("=")
    if not separator:
        raise UserError(f"--set {text}: expected KEY=VALUE, for example --set pi1=18")
    try:
        return key, json.loads(value)
    except json.JSONDecodeError:
        return key, value


def _run(scene: Scene, output: Path, quiet: bool) -> Run:
    from sim import simulate

    bar = tqdm(
        total=100, desc=scene.title, disable=quiet, bar_format="{l_bar}{bar}| {elapsed}<{remaining}"
    )
    with bar:

        def progress(done: float) -> None:
            bar.update(100 * done - bar.n)

        return simulate(scene, output / "run.nc", progress=progress)


def _write(run: Run, output: Path) -> dict[str, Any]:
    """Write tables and picture beside the run and return the numbers of interest."""
    from combing.figures.run import draw_run
    from combing.figures.style import save
    from combing.tables import write_table

    links = _links(run)
    log = run.force_log() if run.scene.tines else None
    write_table(output / "strands.csv", _strands(run), ["positions at every snapshot, metres"])
    if links is not None:
        write_table(output / "link.csv", links, ["link density [1/m] at every snapshot"])
    if log is not None:
        write_table(
            output / "force.csv", log, ["time [s], displacement [m], force on the tine [N]"]
        )
    save(draw_run(run, log, links), output, "run", synthetic=False)
    return _summary(run, log, links, output)


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


def _summary(
    run: Run, log: pd.DataFrame | None, links: pd.DataFrame | None, output: Path
) -> dict[str, Any]:
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
    summary["written to"] = str(output)
    return summary
