"""``combing entangle``: its tables are those of the instruments, its words those of its tables."""

import numpy as np
import pandas as pd
import pytest

import imaging
import sim
from combing.cli import main
from combing.compare.curl_views import ANGLES, seen_from


@pytest.fixture(scope="module")
def curl(tmp_path_factory):
    """Path of a run of four hairs that hang for a moment."""
    path = tmp_path_factory.mktemp("curl") / "run.nc"
    sim.simulate(sim.curl(n=4, elements=20, length=0.05, duration=0.05, snapshots=3)).save(path)
    return path


@pytest.fixture
def entangle(curl, tmp_path, capsys):
    """Run the command; return its exit code, what it said, and a reader of its tables."""

    def entangle(*options):
        with pytest.raises(SystemExit) as ended:
            main(["entangle", str(curl), "-o", str(tmp_path / "out"), *options])
        said = capsys.readouterr()
        return ended.value.code, said.out + said.err

    entangle.table = lambda name: pd.read_csv(tmp_path / "out" / f"{name}.csv", comment="#")
    entangle.folder = tmp_path / "out"
    return entangle


def test_pairs_are_those_of_the_instruments(entangle, curl):
    code, said = entangle()
    assert code == 0
    strands = sim.open_run(curl).strands(-1)
    pairs = entangle.table("pairs").set_index(["strand_a", "strand_b"])
    assert len(pairs) == 6
    pictures = [imaging.crossings(seen_from(strands, degrees)) for degrees in ANGLES]
    for (a, b), row in pairs.iterrows():
        one, other = strands[a - 1], strands[b - 1]
        assert row["link"] == pytest.approx(sim.gauss_link(one, other), abs=1e-4)
        exact = sim.average_crossing_number(one, other)
        assert row["crossings"] == pytest.approx(exact, rel=1e-3)
        seen = [((one["strand_a"] == a) & (one["strand_b"] == b)).sum() for one in pictures]
        assert row["seen"] == pytest.approx(np.mean(seen))
    assert f"4 strands: {pairs['crossings'].sum():.4g} crossings between them" in said
    shown = [(one["kind"] == "inter").sum() for one in pictures]
    assert f"pictures from 6 sides show {min(shown)} to {max(shown)}" in said


def test_tables_agree_with_each_other(entangle):
    entangle("--distance", "0.001", "--cell", "0.01")
    pairs, strands, along = (entangle.table(name) for name in ("pairs", "strands", "along"))
    total = pairs["crossings"].sum()
    assert strands["crossings"].sum() == pytest.approx(2 * total, rel=1e-5)
    amount = (along["crossings"] * along["length"]).sum()
    assert amount == pytest.approx(total + strands["own"].sum(), rel=1e-5)
    field = entangle.table("field")
    assert field["crossings"].sum() * 1e-6 == pytest.approx(amount, rel=1e-5)
    contacts = entangle.table("contacts")
    assert len(contacts) == pairs["contacts"].sum() > 0
    assert (contacts["gap"] < 0.001).all()
    assert strands["contacts"].sum() == 2 * len(contacts)
    assert (along["nearest"] > 0).all()
    assert {path.name for path in entangle.folder.iterdir()} >= {"entanglement.png"}


def test_another_moment_is_another_tangle(entangle, curl):
    entangle("--snapshot", "0")
    first = sim.open_run(curl).strands(0)
    found = entangle.table("pairs")["crossings"][0]
    assert found == pytest.approx(sim.average_crossing_number(*first[:2]), rel=1e-3)


def test_a_moment_that_is_not_there_is_refused(entangle):
    code, said = entangle("--snapshot", "7")
    assert code == 2
    assert "--snapshot 7" in said
    assert "0 to 2" in said
    assert not entangle.folder.exists()


def test_one_strand_alone_is_refused(tmp_path, capsys):
    path = tmp_path / "run.nc"
    curl = sim.curl(n=2, elements=8, length=0.02, duration=0.01, snapshots=2)
    sim.simulate(curl.model_copy(update={"rods": curl.rods[:1]})).save(path)
    with pytest.raises(SystemExit) as ended:
        main(["entangle", str(path), "-o", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert "one strand alone" in capsys.readouterr().err
