"""Tests stacked under one header: told apart by a column of labels, or refused."""

import numpy as np
import pytest

import instron

N = 30
T = np.round(np.arange(N) * 0.2, 1)
X = np.round(T * 0.35, 3)
F = [np.round(k + 2.5 * np.sin(np.arange(N) / (5 + k)) ** 2, 4) for k in range(3)]


def read(tmp_path, header, labels, columns):
    rows = (
        ",".join([str(label), *map(str, row)]) for label, *row in zip(labels, *columns, strict=True)
    )
    path = tmp_path / "stack.csv"
    path.write_text("\n".join([header, *rows, ""]))
    return instron.read(path)


@pytest.mark.parametrize("name", ["Specimen", "sample_id", "Test No.", "Probe Nr.", "Run"])
@pytest.mark.parametrize("labels", [["a", "b", "c"], [1, 2, 3]])
def test_specimens_of_a_label_column_are_told_apart(name, labels, tmp_path):
    columns = np.tile(T, 3), np.tile(X, 3), np.concatenate(F)
    logs = read(tmp_path, f"{name},Time (s),Extension (mm),Load (N)", np.repeat(labels, N), columns)
    assert [log.attrs["specimen"] for log in logs] == [str(label) for label in labels]
    for log, force in zip(logs, F, strict=True):
        np.testing.assert_allclose(log["force"], force)
        np.testing.assert_allclose(log["time"], T)
    assert logs[0].attrs["lines"]["data"] == 3 * N


def test_without_time_the_displacement_that_starts_anew_tells(tmp_path):
    columns = np.tile(X, 2), np.concatenate(F[:2])
    logs = read(tmp_path, "sample,extension_mm,load_N", np.repeat(["p", "q"], N), columns)
    assert [len(log) for log in logs] == [N, N]


def test_a_column_that_counts_rows_or_steps_splits_nothing(tmp_path):
    for labels in (range(N), np.arange(N) // 10):
        (log,) = read(tmp_path, "Sample,Time (s),Extension (mm),Load (N)", labels, (T, X, F[0]))
        np.testing.assert_allclose(log["force"], F[0])


def test_a_column_that_counts_every_few_of_many_rows_is_no_label(tmp_path):
    t = np.round(np.arange(30_000) * 0.02, 2)
    columns = t, np.round(t * 0.35, 4), np.round(3 * np.sin(t / 40) ** 2 + 0.001, 4)
    header = "Sample,Time (s),Extension (mm),Load (N)"
    (log,) = read(tmp_path, header, np.arange(len(t)) // 7, columns)
    assert not log.attrs["warnings"]


def test_tests_appended_without_time_or_label_are_refused(tmp_path):
    columns = np.tile(X, 2), np.concatenate(F[:2])
    with pytest.raises(instron.Unreadable, match=r"line 32: displacement jumps from .* in one row"):
        read(tmp_path, "remark,extension_mm,load_N", ["x"] * (2 * N), columns)


def test_a_return_of_the_crosshead_is_no_new_test(tmp_path):
    there = np.concatenate([X, X[::-1]])
    (log,) = read(tmp_path, "Run,Extension (mm),Load (N)", [1] * (2 * N), (there, np.tile(F[0], 2)))
    assert len(log) == 2 * N


@pytest.mark.parametrize("name", ["File", "Material", "Fibre", "", "Temperature (C)"])
@pytest.mark.parametrize("timed", [True, False])
def test_what_changes_where_tests_begin_anew_names_them(name, timed, tmp_path):
    labels = np.repeat(["20", "45", "60"] if name.startswith("Temp") else ["pa", "pe", "pp"], N)
    columns = [np.tile(X, 3), np.concatenate(F)]
    header = f"{name},Extension (mm),Load (N)"
    if timed:
        columns.insert(0, np.tile(T, 3))
        header = f"{name},Time (s),Extension (mm),Load (N)"
    logs = read(tmp_path, header, labels, columns)
    assert [log.attrs["specimen"] for log in logs] == list(dict.fromkeys(labels))
    for log, force in zip(logs, F, strict=True):
        np.testing.assert_allclose(log["force"], force)


def test_two_columns_name_a_specimen_together(tmp_path):
    labels = np.repeat(["pa,1", "pa,2", "pe,1"], N)
    columns = np.tile(X, 3), np.concatenate(F)
    logs = read(tmp_path, "Material,Specimen,Extension (mm),Load (N)", labels, columns)
    assert [log.attrs["specimen"] for log in logs] == ["pa, 1", "pa, 2", "pe, 1"]


def test_specimens_that_come_back_to_the_start_are_told_apart(tmp_path):
    there = np.concatenate([X[: N // 2], X[: N // 2][::-1]])
    columns = np.tile(there, 2), np.concatenate(F[:2])
    logs = read(tmp_path, "Trial,Extension (mm),Load (N)", np.repeat(["1", "2"], N), columns)
    assert [len(log) for log in logs] == [N, N]


def test_specimens_of_one_long_clock_are_told_apart(tmp_path):
    time = np.round(np.arange(2 * N) * 0.2, 1)
    columns = time, np.tile(X, 2), np.concatenate(F[:2])
    logs = read(tmp_path, "Specimen,Time (s),Extension (mm),Load (N)",
                np.repeat(["p", "q"], N), columns)  # fmt: skip
    assert [log["time"].iloc[0] for log in logs] == pytest.approx([0, 6.0])


@pytest.mark.parametrize("name", ["Run", "Remark"])
def test_a_label_that_changes_while_the_test_runs_on_is_said(name, tmp_path):
    labels = np.repeat(["first", "second"], N // 2)
    (log,) = read(tmp_path, f"{name},Time (s),Extension (mm),Load (N)", labels, (T, X, F[0]))
    (said,) = [note for note in log.attrs["warnings"] if "read as one test" in note]
    assert said.startswith(f"line 17: '{name}' changes from 'first' to 'second'")


STAGES = {"Cycle": ["1", "2"], "Number": ["1", "2"], "Part": ["loading", "unloading"],
          "Mode": ["Step 1", "Step 2"]}  # fmt: skip


@pytest.mark.parametrize(("name", "labels"), STAGES.items())
def test_cycles_and_stages_are_no_specimens(name, labels, tmp_path):
    columns = np.tile(T, 2), np.concatenate([X, X[::-1]]), np.concatenate(F[:2])
    with pytest.raises(instron.Unreadable, match="time jumps back"):
        read(tmp_path, f"{name},Time (s),Extension (mm),Load (N)", np.repeat(labels, N), columns)
