"""The first page a stranger reads: every example on it is run as it is written."""

import re
import shlex
from pathlib import Path

import pytest

from combing.cli import main
from combing.virtual_lab.packaged import data_folder

PAGE = Path(__file__).parents[2] / "docs" / "start.md"
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.M | re.S)
ELSEWHERE = ("pip install", "combing demo")  # .ci/run begins with them


@pytest.mark.slow
def test_every_example_of_the_start_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "data").symlink_to(data_folder())
    shell = [line for kind, block in BLOCKS if not kind for line in block.splitlines()]
    for line in shell:
        if not line.startswith(ELSEWHERE):
            _command(line)
    capsys.readouterr()
    for kind, block in BLOCKS:
        if kind == "python":
            exec(compile(block, str(PAGE), "exec"), {})  # noqa: S102
    said = capsys.readouterr().out
    strands, crossings = map(int, re.match(r"(\d+) strands, (\d+) crossings", said).groups())
    assert 12 <= strands <= 15  # twelve hairs, and ends that come out from under others
    assert crossings > strands
    assert 50 < float(re.search(r"f_max = ([\d.]+)", said).group(1)) < 200
    named = ("curl/overlay.jpg", "curl/crossings.csv", "curl/DATA.md", "force/force.png")
    for made in (*named, "force/summary.csv", "run/run.nc", "run/run.html"):
        assert (tmp_path / made).is_file(), made


def _command(line: str) -> None:
    program, *arguments = shlex.split(line)
    assert program == "combing"
    with pytest.raises(SystemExit) as leaving:
        main(arguments)
    assert not leaving.value.code, line
