"""The command line as a whole: help, errors, exit codes."""

import pytest

from combing.cli import COMMANDS, main


def run(*arguments):
    """Return the exit code of the command line."""
    with pytest.raises(SystemExit) as stopped:
        main(list(arguments))
    return stopped.value.code


@pytest.mark.parametrize("command", COMMANDS)
def test_every_help_shows_an_example_on_lines_of_its_own(command, capsys):
    assert run(command, "--help") == 0
    lines = capsys.readouterr().out.splitlines()
    at = next(i for i, line in enumerate(lines) if line.strip() == "Example:")
    assert lines[at + 1].strip().startswith(f"combing {command}")


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["photos"], "No such command 'photos'"),
        (["photo", "none.jpg", "--colour", "red"], "No such option"),
        (["force"], "Missing argument"),
    ],
)
def test_a_wrong_call_gets_one_line_and_exit_code_two(arguments, expected, capsys):
    assert run(*arguments) == 2
    message = capsys.readouterr().err
    assert expected in message
    assert "--help" in message
    assert len(message.strip().splitlines()) == 1


def test_debug_shows_the_traceback(capsys):
    with pytest.raises(Exception, match="no such file"):
        main(["--debug", "simulate", "none.toml"])


def test_a_defect_of_ours_is_not_passed_off_as_the_users(monkeypatch):
    monkeypatch.setattr("sim.load_scene", lambda path, **overrides: 1 / 0, raising=False)
    with pytest.raises(ZeroDivisionError):
        main(["simulate", "scene.toml"])
