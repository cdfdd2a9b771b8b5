"""``combing force``: exports of a testing machine to f(x), repeats, events, and a figure."""

import html
import json
import shutil
import tempfile
from pathlib import Path
from typing import Any

import click
import pandas as pd
from tqdm import tqdm

import instron
from combing.errors import UserError

FEWEST = 4  # repeats for which the band's coverage was measured to hold
Skipped = list[tuple[Path, str]]


@click.command()
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--rig", "rig_file", type=click.Path(path_type=Path), help="Rig TOML: r and E, or B.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for the results.")
@click.option("--active-length", type=float, help="Natural height [m] of the helix that Love's "
              "curve stretches; without it no theory is drawn.")  # fmt: skip
@click.option("--ends", type=click.Choice(["free", "blocked"]), default="free", show_default=True,
              help="Whether the ends of Love's helix may turn.")  # fmt: skip
@click.option("--columns", help="For a file without header: e.g. time,displacement,force.")
@click.option("--column", "headings", multiple=True, metavar="QUANTITY=HEADING", help="Which "
              "heading is which quantity, where a file leaves a doubt: force='Kraft Ist', or "
              "force=#4. The others are found as ever.")  # fmt: skip
@click.option("--units", help="Units that a file does not state: e.g. force=lbf,displacement=in.")
@click.option("--explain", is_flag=True, help="Only say what was understood of each file and of "
              "its lines.")  # fmt: skip
@click.option("--skip-unreadable", is_flag=True, help="Go on without the files that cannot be "
              "read; they are listed with reasons.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print the result as JSON.")
@click.option("--quiet", is_flag=True, help="No progress, no warnings.")
def command(
    files: tuple[Path, ...],
    rig_file: Path | None,
    output: Path | None,
    active_length: float | None,
    ends: str,
    columns: str | None,
    headings: tuple[str, ...],
    units: str | None,
    explain: bool,
    skip_unreadable: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Turn force logs into scaled curves f(x), with repeats, events and Love's curve.

    FILES are exports (CSV, TXT, TRA, DAT) or folders of them; each specimen is one repeat.

    \b
    Example:
      combing force run1.csv run2.csv run3.csv --rig rig.toml -o out/
      combing force --explain run1.csv
    where rig.toml holds, say:
      r = 4.25e-4   # filament radius [m]
      E = 2.8e9     # Young's modulus [Pa]
    """
    told = _told(columns, headings, units)
    found, passed = _expand(files)
    logs, unread = _read_all(found, told, explain or skip_unreadable, quiet or explain)
    skipped = unread + passed
    if explain:
        click.echo(_explained(logs, skipped, as_json))
        return
    if not quiet:
        for _, reason in skipped:
            click.echo(f"combing: skipped: {reason}", err=True)
    logs = _once(logs)
    if rig_file is None:
        raise UserError("--rig is missing: f = l0^2 F/B needs the filament (r and E, or B)")
    rig = instron.load_rig(rig_file)
    curves = [instron.scale(log, rig) for log in logs]
    theory = _theory(rig, curves, active_length, ends)
    if not quiet:
        _warn(curves)
    result = _combine(curves)
    if output is not None:
        _write(output, curves, result, theory, skipped)
    click.echo(_as_json(curves, result) if as_json else _summary_text(curves, result, output))


def explanation(log: pd.DataFrame) -> str:
    """Return about ten lines on what was understood of one specimen of a file."""
    facts, dialect = log.attrs, log.attrs["dialect"]
    thousands = "grouped thousands" if dialect["thousands"] else "no grouped thousands"
    lines = [
        f"{facts['source']}",
        f"  specimen   {facts['specimen']}",
        f"  text       {dialect['encoding']}, {dialect['newline']}, delimiter"
        f" '{dialect['delimiter']}', decimal '{dialect['decimal']}', {thousands}",
        f"  header     line {dialect['header_line']}, data from line {dialect['first_row']},"
        f" {len(log)} rows, {len(facts['metadata'])} metadata lines",
    ]
    lines += [_column_line(log, quantity) for quantity in ("time", "displacement", "force")]
    roles = ", ".join(f"{count} {role}" for role, count in facts["lines"].items())
    lines.append(f"  lines      {sum(facts['lines'].values())}: {roles}")
    lines.append(f"  stated     {facts['stated'] or 'no maximum load to check against'}")
    lines += [f"  choice     {note}" for note in facts["choices"]]
    lines += [f"  warning    {note}" for note in facts["warnings"]] or ["  checks     all passed"]
    return "\n".join(lines)


def _column_line(log: pd.DataFrame, quantity: str) -> str:
    column = log.attrs["columns"].get(quantity)
    if column is None:
        return f"  {quantity:<12} absent"
    unit = {"time": "s", "displacement": "m", "force": "N"}[quantity]
    values = log[quantity]
    return (
        f"  {quantity:<12} column {column['index'] + 1} '{column['name']}' in {column['unit']}:"
        f" {values.min():.6g} to {values.max():.6g} {unit}"
    )


def _expand(files: tuple[Path, ...]) -> tuple[list[Path], Skipped]:
    """Replace folders by the exports in them; what else is in them is named."""
    found: list[Path] = []
    passed: Skipped = []
    for path in files:
        if path.is_dir():
            inside, others = instron.exports(path)
            found += inside
            passed += others
        elif not path.exists():
            raise UserError(f"{path}: no such file")
        else:
            found.append(path)
    return found, passed


def _told(columns: str | None, headings: tuple[str, ...], units: str | None) -> dict[str, Any]:
    """Return what the options say of columns and units, as ``instron.read`` takes it."""
    if columns and headings:
        raise UserError(
            "--columns is for files without headings, --column for those with: not both"
        )
    named = dict(_heading(text) for text in headings)
    bare = [name.strip() for name in columns.split(",")] if columns else None
    return {"columns": named or bare,
            "units": dict(_pair(part) for part in units.split(",")) if units else None}  # fmt: skip


def _read_all(
    files: list[Path], told: dict[str, Any], go_on: bool, quiet: bool
) -> tuple[list[pd.DataFrame], Skipped]:
    """Return the logs of all files, and which could not be read and why."""
    logs: list[pd.DataFrame] = []
    skipped: Skipped = []
    for path in tqdm(files, desc="reading", unit="file", disable=quiet or len(files) < 20):
        try:
            logs += instron.read(path, **told)
        except instron.Unreadable as error:
            if not go_on:
                hint = "; --skip-unreadable goes on without it" if len(files) > 1 else ""
                raise instron.Unreadable(f"{error}{hint}") from None
            skipped.append((path, str(error)))
    if not logs and skipped:
        raise instron.Unreadable(skipped[0][1])
    return logs, skipped


def _once(logs: list[pd.DataFrame]) -> list[pd.DataFrame]:
    """Return the logs, those that hold the same numbers once."""
    kept: dict[bytes, pd.DataFrame] = {}
    for log in logs:
        content = b"".join(log[q].to_numpy().tobytes() for q in ("displacement", "force"))
        first = kept.setdefault(content, log)
        if first is not log:
            click.echo(
                f"combing: {log.attrs['source']}: the same numbers as {first.attrs['source']}:"
                " counted once", err=True)  # fmt: skip
    return list(kept.values())


def _explained(logs: list[pd.DataFrame], skipped: Skipped, as_json: bool) -> str:
    if as_json:
        unread = [{"source": str(path), "unreadable": reason} for path, reason in skipped]
        return json.dumps([_plain(log.attrs) for log in logs] + unread, indent=1)
    return "\n\n".join(
        [*map(explanation, logs), *(f"{path}\n  unreadable {why}" for path, why in skipped)]
    )


def _heading(text: str) -> tuple[str, str]:
    quantity, _, heading = text.partition("=")
    if quantity.strip() not in ("time", "displacement", "force") or not heading.strip():
        raise UserError(f'--column {text!r}: write it as --column force="Kraft Ist"')
    return quantity.strip(), heading.strip()


def _pair(text: str) -> tuple[str, str]:
    quantity, _, unit = text.partition("=")
    if quantity.strip() not in ("time", "displacement", "force") or not unit:
        raise UserError(f"--units {text!r}: write it as force=lbf,displacement=in,time=min")
    return quantity.strip(), unit.strip()


def _theory(
    rig: instron.Rig, curves: list[pd.DataFrame], active_length: float | None, ends: str
) -> pd.DataFrame | None:
    """Return Love's curve over the mean D, cut a little above the measured forces."""
    if active_length is None:
        return None
    D = sum(c.attrs["D"] for c in curves) / len(curves)
    top = 1.5 * max(c.attrs["f_max"] for c in curves)
    return instron.theory_curve(rig, active_length, D, ends=ends, f_limit=top)  # type: ignore[arg-type]


def _combine(curves: list[pd.DataFrame]) -> instron.Repeats | None:
    """Combine the repeats that combed to the end, if there are two."""
    return instron.repeats(curves) if sum(c.attrs["ended"] for c in curves) > 1 else None


def _warn(curves: list[pd.DataFrame]) -> None:
    for curve in curves:
        for note in curve.attrs["warnings"]:
            click.echo(f"combing: {curve.attrs.get('source', '')}: {note}", err=True)


def _summary_text(
    curves: list[pd.DataFrame], result: instron.Repeats | None, output: Path | None
) -> str:
    shown = ["specimen", "f_max", "D", "w", "W", "mid_force", "end_peak", "peaks", "largest_event"]
    table = _per_repeat(curves)
    text = table[shown].to_string(index=False, float_format=lambda v: f"{v:.5g}")
    text += f"\nF averaged over {_lengths(curves)} of d; d in m, W in J, forces in N\n"
    text += "\n".join(map(_uncertainty, curves))
    if result is not None:
        text += f"\n\nover {len(result.used)} repeats (interval of the mean at 95 %)\n"
        text += result.summary.to_string(float_format=lambda v: f"{v:.5g}")
        if len(result.used) < FEWEST:
            text += f"\nfewer than {FEWEST} repeats: the band of mean.csv covers less than it says"
        if result.registered is None:
            text += f"\nno registered mean: {result.unregistered_because}"
    left_out = [_name(c) for c in curves if not c.attrs["ended"]]
    if left_out and len(curves) > 1:
        text += f"\ncombing did not end in {', '.join(left_out)}: in no mean"
    return text + (f"\nwritten to {output}" if output else "")


def _lengths(curves: list[pd.DataFrame]) -> str:
    low, high = (pick(c.attrs["average_over"] for c in curves) for pick in (min, max))
    return f"{low:.3g} m" if high - low < 1e-3 * low else f"{low:.3g} to {high:.3g} m"


def _uncertainty(curve: pd.DataFrame) -> str:
    """Return the intervals of one curve as a line."""
    a = curve.attrs
    relative = a["f_relative"]
    rig = "not stated (u_r, u_E)" if relative != relative else f"{relative:.2%}"
    peak = f"f_max {a['f_max_low']:.5g} to {a['f_max_high']:.5g}"
    end = f"D {a['D_low']:.5g} to {a['D_high']:.5g} m" if a["ended"] else "combing did not end"
    return (
        f"{_name(curve)}: {peak}, {end} by noise (95 %);"
        f" standard uncertainty of f by r and E: {rig}"
    )


def _name(curve: pd.DataFrame) -> str:
    return str(curve.attrs.get("specimen", ""))


def _per_repeat(curves: list[pd.DataFrame]) -> pd.DataFrame:
    """Return one row for every curve, those that did not comb to the end included."""
    return pd.DataFrame(
        [{"specimen": _name(c)} | instron.summary(c) | {"ended": c.attrs["ended"]} for c in curves]
    )


def _as_json(curves: list[pd.DataFrame], result: instron.Repeats | None) -> str:
    keys = ("source", "specimen", "ended", "average_over", "B", "noise", "noise_averaged",
            "f_noise", "f_noise_averaged", "f_relative", "rules", "warnings")  # fmt: skip
    found: dict[str, Any] = {
        "curves": [{k: c.attrs.get(k) for k in keys} | instron.summary(c) for c in curves]
    }
    if result is not None:
        found["repeats"] = result.table.to_dict("records")
        found["summary"] = result.summary.to_dict("index")
        found["representative"] = result.used[result.representative]
        found["left_out"] = result.left_out
        found["unregistered_because"] = result.unregistered_because
    return json.dumps(_plain(found), indent=1)


def _plain(value: Any) -> Any:
    """Return the value as JSON knows it; NaN becomes null."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and value != value else value


def _write(
    output: Path,
    curves: list[pd.DataFrame],
    result: instron.Repeats | None,
    theory: pd.DataFrame | None,
    skipped: Skipped,
) -> None:
    """Write all results into a temporary folder first, so that none stays half-written."""
    if output.exists() and not output.is_dir():
        raise UserError(f"{output}: is a file; -o wants a folder")
    # matplotlib takes longer to import than most files to read.
    from combing.figures.repeats import draw_repeats

    room = _room_beside(output)
    try:
        _write_tables(room, curves, result, theory)
        if skipped:
            pd.DataFrame(skipped, columns=["file", "reason"]).to_csv(
                room / "skipped.csv", index=False
            )
        draw_repeats(curves, result, theory, room / "force")
        _write_section(room, curves, result)
        output.mkdir(exist_ok=True)
        for path in room.iterdir():
            path.replace(output / path.name)
    finally:
        shutil.rmtree(room, ignore_errors=True)


def _room_beside(output: Path) -> Path:
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        return Path(tempfile.mkdtemp(prefix=".force-", dir=output.parent))
    except OSError as error:
        raise UserError(f"{output}: cannot be written: {error.strerror}") from None


def _write_tables(
    room: Path,
    curves: list[pd.DataFrame],
    result: instron.Repeats | None,
    theory: pd.DataFrame | None,
) -> None:
    _tidy(curves).to_csv(room / "curves.csv", index=False)
    _tidy([_tagged(instron.events(c), c) for c in curves]).to_csv(room / "events.csv", index=False)
    table = _per_repeat(curves)
    table.insert(1, "file", list(map(_file, curves)))
    table.to_csv(room / "repeats.csv", index=False)
    if result is not None:
        result.grid.to_csv(room / "mean.csv", index=False)
        result.summary.to_csv(room / "summary.csv", index_label="quantity")
        if result.registered is not None:
            result.registered.to_csv(room / "mean_registered.csv", index=False)
    if theory is not None:
        theory.to_csv(room / "theory.csv", index=False)


def _tagged(found: pd.DataFrame, curve: pd.DataFrame) -> pd.DataFrame:
    found.attrs |= {key: curve.attrs.get(key, "") for key in ("specimen", "source")}
    return found


def _file(table: pd.DataFrame) -> str:
    return Path(table.attrs.get("source", "")).name


def _tidy(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """Stack tables with the repeat's number and name in front."""
    parts = []
    for number, table in enumerate(tables, start=1):
        part = pd.DataFrame({"repeat": number, "specimen": table.attrs.get("specimen", ""),
                             "file": _file(table)}, index=table.index)  # fmt: skip
        parts.append(pd.concat([part, pd.DataFrame(table.to_dict("series"))], axis=1))
    return pd.concat([part for part in parts if len(part)] or parts[:1], ignore_index=True)


def _write_section(room: Path, curves: list[pd.DataFrame], result: instron.Repeats | None) -> None:
    """Write a section for a report: figure inline, tables, and every warning."""
    svg = (room / "force.svg").read_text(encoding="utf-8")
    table = _per_repeat(curves).to_html(index=False, float_format="{:.5g}".format, border=0)
    summary = result.summary.to_html(float_format="{:.5g}".format, border=0) if result else ""
    notes = [
        f"{c.attrs.get('specimen', '')}: {note}" for c in curves for note in c.attrs["warnings"]
    ]
    items = "".join(f"<li>{html.escape(note)}</li>" for note in notes)
    parts = ['<section id="force">', "<h2>Force of combing</h2>", svg[svg.index("<svg") :], table,
             summary, f"<ul>{items}</ul>" if items else "", "</section>"]  # fmt: skip
    (room / "section.html").write_text("\n".join(filter(None, parts)) + "\n", encoding="utf-8")
