"""Processes that simulate: none outlives who asked, none takes the others' work along."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import sim
from combing.workers import LIVES, Crew, Died

ROOT = Path(__file__).parents[2]
SLOW = "sim.double_helix(18, height=0.15, seed={seed})"
ASKING = f"""
import sim, sys
from pathlib import Path
from combing.runs import simulating
if __name__ == "__main__":
    scenes = {{seed: {SLOW.format(seed="seed")} for seed in (1, 2)}}
    with simulating(scenes, Path(sys.argv[1]), jobs=2, quiet=True) as wait:
        wait()
"""


def alive(group):
    """Return the processes of a group, by what the system tells of each."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, its_group = path.read_text().rpartition(")")[2].split()[:3]
        except (OSError, ValueError):
            continue
        if int(its_group) == group and state != "Z":
            found.append(int(path.parent.name))
    return found


def until(true, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if true():
            return True
        time.sleep(0.1)
    return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks at processes in /proc")
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_no_process_outlives_the_one_that_asked(tmp_path, how):
    (tmp_path / "ask.py").write_text(ASKING)
    asking = subprocess.Popen(
        [sys.executable, "ask.py", "runs"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        start_new_session=True,
        stderr=subprocess.PIPE,
    )
    try:
        assert until(lambda: len(list(tmp_path.glob("runs/*.part"))) == 2, 120)
        assert len(alive(asking.pid)) >= 3
        asking.send_signal(how)
        asking.wait(20)
        assert until(lambda: not alive(asking.pid), 20)
    finally:
        for process in alive(asking.pid):
            os.kill(process, signal.SIGKILL)
        asking.communicate()


def short(seed):
    return sim.double_helix(18, turns=3, elements_per_pitch=6, speed=0.4, seed=seed)


def test_a_process_that_dies_does_not_take_the_others_work_along(tmp_path):
    scenes = {tmp_path / f"{seed}.nc": short(seed) for seed in range(3)}
    crew = Crew(scenes, 1)
    killed, ended = [], {}

    def look():
        if not killed and crew.fraction > 0:
            (worker,) = crew._pool._processes
            os.kill(worker, signal.SIGKILL)
            killed.append(worker)

    crew.wait(look, ended.__setitem__)
    crew.dismiss()
    assert killed
    assert ended == dict.fromkeys(scenes)
    assert all(path.exists() for path in scenes)


def test_a_scene_whose_process_dies_again_and_again_is_given_up(tmp_path):
    crew = Crew({tmp_path / "a.nc": sim.double_helix(18, height=0.15)}, 1)
    killed, ended = [], {}

    def look():
        workers = set(crew._pool._processes or {})
        if crew.fraction > 0 and not workers & set(killed):
            killed.extend(workers)
            for worker in workers:
                os.kill(worker, signal.SIGKILL)

    crew.wait(look, ended.__setitem__)
    crew.stop()
    assert isinstance(ended[tmp_path / "a.nc"], Died)
    assert len(killed) == LIVES
