"""What a library says of its own accord, printed while a command runs."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import click


class _Echo(logging.Handler):
    """Print on standard error; unlike a stream handler it follows a redirected one."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one line."""
        click.echo(self.format(record), err=True)


@contextmanager
def said_aloud(name: str, *, quiet: bool) -> Iterator[None]:
    """Print what is logged on logger `name` on standard error; warnings alone when quiet."""
    log, handler = logging.getLogger(name), _Echo()
    before = log.level
    log.setLevel(logging.WARNING if quiet else logging.INFO)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(before)
