"""Sweeps on a dask cluster: a worker that is killed costs no point."""

import os
import signal

import pytest

from combing.errors import UserError
from combing.study import load_sweep
from combing.sweep import Store, run_sweep
from combing.sweep.cluster import cluster

SWEEP = """
preset = "double_helix"
[fixed]
turns = 3
elements_per_pitch = 6
speed = 0.5
snapshots = 2
[grid]
pi1 = [18, 20, 24]
"""


@pytest.mark.filterwarnings("default")
def test_a_killed_worker_is_replaced_and_its_point_done(tmp_path):
    distributed = pytest.importorskip("distributed", reason="needs the cluster extra")
    (tmp_path / "sweep.toml").write_text(SWEEP)
    sweep = load_sweep(tmp_path / "sweep.toml")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None
    ) as local, distributed.Client(local) as client:  # fmt: skip
        (worker,) = client.run(os.getpid).values()

        def start(scenes):
            engine = cluster(local.scheduler_address)(scenes)
            os.kill(worker, signal.SIGKILL)
            return engine

        table = run_sweep(sweep, tmp_path / "out", quiet=True, start=start)
        assert table["state"].tolist() == ["done"] * 3
        (after,) = client.run(os.getpid).values()
        assert after != worker
    store = Store(tmp_path / "out")
    assert all(store.results(member)["f_max"] > 0 for member in sweep.members())


@pytest.mark.filterwarnings("default")
def test_a_scheduler_that_does_not_answer_is_named(monkeypatch):
    pytest.importorskip("distributed", reason="needs the cluster extra")
    monkeypatch.setattr("combing.sweep.cluster.PATIENCE", "1s")
    with pytest.raises(UserError, match="tcp://127.0.0.1:9: no dask scheduler answers"):
        cluster("tcp://127.0.0.1:9")
