"""A report says what ran, and on what."""

import hashlib
import json

import pytest

from combing.compare.bench import compare
from combing.compare.provenance import command, commit, provenance
from combing.runs import model_version
from combing.study import load_study


@pytest.fixture
def study(tmp_path):
    rows = "\n".join(f"{t / 10},{t / 10},{max(0, 3 - abs(t - 60) / 20)}" for t in range(200))
    (tmp_path / "a.csv").write_text(f"Time,Extension,Load\n(s),(mm),(N)\n{rows}\n")
    (tmp_path / "rig.toml").write_text("r = 4e-4\nE = 1e9\nzero = 'none'\n")
    text = 'title = "t"\n[[force]]\nname = "a"\nlogs = "a.csv"\nrig = "rig.toml"\n'
    (tmp_path / "study.toml").write_text(text)
    return load_study(tmp_path / "study.toml")


def test_every_file_that_the_study_names_is_there_with_its_hash(study, tmp_path):
    found = provenance(study)
    assert [one["file"] for one in found["inputs"]] == ["study.toml", "a.csv", "rig.toml"]
    for one in found["inputs"]:
        content = (tmp_path / one["file"]).read_bytes()
        assert one["bytes"] == len(content)
        assert one["sha256"] == hashlib.sha256(content).hexdigest()
    assert found["solver"] == model_version()
    assert {"python", "numpy", "numba"} <= set(found["versions"])


def test_report_and_summary_hold_it(study, tmp_path):
    compare(study, tmp_path / "out", quiet=True)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["provenance"]["study"] == str(tmp_path / "study.toml")
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for one in summary["provenance"]["inputs"]:
        assert one["sha256"][:16] in report


def test_a_command_is_what_was_typed():
    typed = ["/usr/bin/combing", "compare", "my study.toml", "-o", "out"]
    assert command(typed) == "combing compare 'my study.toml' -o out"
    assert command(["/usr/bin/pytest", "-q"]) is None


def test_what_is_in_no_checkout_has_no_commit(tmp_path):
    (tmp_path / "__init__.py").touch()
    assert commit(tmp_path) is None
