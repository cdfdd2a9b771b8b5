"""What a study file says, and what its writer is told when it says something wrong."""

import pytest

import instron
from combing.errors import UserError
from combing.study import StudyError, load_study, tine_positions

FORCE = 'title = "t"\n[[force]]\nname = "a"\nlogs = "logs/*.csv"\nrig = "rig.toml"\n'
LINK = 'title = "t"\n[[link]]\nname = "b"\nphotos = "*.jpg"\npixel_size = 5e-5\n'


@pytest.fixture
def write(tmp_path):
    (tmp_path / "logs").mkdir()
    for name in ("logs/b.csv", "logs/a.csv", "rig.toml", "1.jpg", "2.jpg", "scene.toml"):
        (tmp_path / name).touch()
    (tmp_path / "few.csv").write_text("photo,x\n1.jpg,0.01\n")
    (tmp_path / "where.csv").write_text("# m\nphoto,d\n2.jpg,0.02\n1.jpg,0.01\n")

    def write(text):
        path = tmp_path / "study.toml"
        path.write_text(text)
        return path

    return write


def test_paths_are_relative_to_the_study_and_patterns_sorted(write, tmp_path, monkeypatch):
    monkeypatch.chdir("/")
    study = load_study(write(FORCE))
    assert study.force[0].logs == [tmp_path / "logs/a.csv", tmp_path / "logs/b.csv"]
    assert study.n_sec == 20


def test_absolute_patterns_are_taken_as_they_are(write, tmp_path):
    study = load_study(write(FORCE.replace("logs/*.csv", f"{tmp_path}/logs/a*.csv")))
    assert study.force[0].logs == [tmp_path / "logs/a.csv"]


def test_positions_come_from_a_list_or_a_table(write):
    listed = load_study(write(LINK + "positions = [0.01, 0.02]"))
    looked_up = load_study(write(LINK + 'positions = "where.csv"'))
    assert tine_positions(listed.link[0]) == tine_positions(looked_up.link[0]) == [0.01, 0.02]


def test_simulations_are_named_once(write):
    scene = 'simulation = "scene.toml"\n'
    curl = '[[curl]]\nname = "c"\nphotos = "1.jpg"\npixel_size = 1e-5\nsimulations = "*.toml"\n'
    study = load_study(write(FORCE + scene + LINK.split("\n", 1)[1] + scene + "positions=[1, 2]\n"))
    assert [path.name for path in study.simulations] == ["scene.toml"]
    study = load_study(write(FORCE + scene + curl.replace("*.toml", "s*e.toml")))
    assert [path.name for path in study.simulations] == ["scene.toml"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (FORCE + "active_lenght = 1", "[[force]] 1: unknown key 'active_lenght'; did you mean"),
        (FORCE.replace("title", "titel"), "unknown key 'titel'; did you mean 'title'"),
        (FORCE + "zzz = 1", "known are name, logs, rig"),
        (FORCE + "active_length = -1", "active_length: input should be greater than 0, not -1"),
        (FORCE.replace("*.csv", "*.txt"), "logs: no file matches"),
        (FORCE + 'simulation = "none.toml"', "simulation: there is no file"),
        (FORCE + "simulation = 3", "expected a file name in quotes"),
        (FORCE.replace('rig = "rig.toml"', ""), "the key 'rig' is missing"),
        (FORCE.replace("[[force]]", "[force]"), "write [[force]] above each"),
        ('title = "t"', "nothing to compare"),
        ("title = ", "not TOML: Invalid value"),
        (LINK, "the key 'positions' is missing"),
        (LINK + "positions = [0.01]", "2 photographs but 1 positions"),
        (LINK + 'positions = "rig.toml"', "not a comma-separated table"),
        (LINK + 'positions = "few.csv"', "needs the column 'd'; has photo, x"),
        (LINK + 'positions = ["a", "b"]', "valid number"),
        (LINK.replace("pixel_size = 5e-5", "positions = [1, 2]"), "give the scale"),
        (LINK.replace("5e-5", "-1.0") + "positions = [1, 2]", "greater than 0, not -1.0"),
    ],
)  # fmt: skip
def test_a_wrong_study_gets_one_clear_line(write, text, message):
    with pytest.raises(UserError) as caught:
        load_study(write(text))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_study_is_named(tmp_path):
    with pytest.raises(StudyError, match="no such study file"):
        load_study(tmp_path / "none.toml")


def test_a_study_may_hold_the_rig_of_its_logs(tmp_path):
    (tmp_path / "a.csv").write_text("x")
    text = 'title = "t"\n[rig]\nr = 4e-4\nE = 1e9\n[[force]]\nname = "a"\nlogs = "a.csv"\n'
    (tmp_path / "study.toml").write_text(text)
    (one,) = load_study(tmp_path / "study.toml").force
    rig = instron.load_rig(one.rig)
    assert (rig.r, rig.E) == (4e-4, 1e9)
    (tmp_path / "own.toml").write_text("B = 1e-6\n")
    (tmp_path / "study.toml").write_text(text + 'rig = "own.toml"\n')
    assert load_study(tmp_path / "study.toml").force[0].rig.name == "own.toml"


def test_a_rig_that_no_set_needs_is_told(tmp_path):
    (tmp_path / "study.toml").write_text('title = "t"\n[rig]\nr = 4e-4\nE = 1e9\n')
    with pytest.raises(StudyError, match=r"study.toml: \[rig\]: there is no set with logs"):
        load_study(tmp_path / "study.toml")
