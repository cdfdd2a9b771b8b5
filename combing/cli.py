"""The ``combing`` command: one group, one module per subcommand, one place for errors."""

import importlib
import signal
import sys
from typing import NoReturn

import click

from combing import __version__
from combing.errors import is_users_fault

COMMANDS = {
    "photo": "combing.commands.photo",
    "edit": "combing.commands.edit",
    "helix": "combing.commands.helix",
    "force": "combing.commands.force",
    "simulate": "combing.commands.simulate",
    "view": "combing.commands.view",
    "entangle": "combing.commands.entangle",
    "sweep": "combing.commands.sweep",
    "fit": "combing.commands.fit",
    "compare": "combing.commands.compare",
    "claims": "combing.commands.claims",
    "paper": "combing.commands.paper",
    "accuracy": "combing.commands.accuracy",
    "demo": "combing.commands.demo",
    "virtual-lab": "combing.commands.virtual_lab",
}


class LazyGroup(click.Group):
    """Import a subcommand only when it is asked for, so that ``--help`` and errors stay quick."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the subcommands in the order of a session at the bench."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import and return the subcommand, or None for click's own 'no such command'."""
        if name not in COMMANDS:
            return None
        return importlib.import_module(COMMANDS[name]).command


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="combing")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
@click.pass_context
def combing(ctx: click.Context, debug: bool) -> None:
    """Measure tangled strands: photographs, force logs and simulations on the same axes.

    \b
    Example:
      combing demo
      combing compare study.toml -o out/
    """
    ctx.obj = {"debug": debug}


def _terminated(number: int, frame: object) -> NoReturn:
    """Leave by way of every `finally`, so that nothing half-written and no process stays."""
    sys.exit(128 + number)


def main(args: list[str] | None = None) -> None:
    """Run the command line and exit.

    0 done, 3 done but for parts whose input is at fault, 2 the user's input is at fault, 1 a defect
    of ours.
    """
    arguments = sys.argv[1:] if args is None else args
    signal.signal(signal.SIGTERM, _terminated)
    try:
        code = combing.main(args=arguments, prog_name="combing", standalone_mode=False)
        sys.exit(code if isinstance(code, int) else 0)
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx else "combing"
        click.echo(f"combing: {error.format_message()} (see {command} --help)", err=True)
        sys.exit(2)
    except click.Abort:
        click.echo("combing: interrupted", err=True)
        sys.exit(130)
    except Exception as error:
        if "--debug" in arguments or not is_users_fault(error):
            raise
        click.echo(f"combing: {error}", err=True)
        sys.exit(2)
