"""What this instrument says when an input is at fault."""


class Unreadable(Exception):
    """A file that cannot be read exactly; the message names file, line and reason."""

    users_fault = True


class NoLog(Unreadable):
    """A table, a sheet or a text that is no force log at all."""


class RigError(Exception):
    """A rig or specimen description that is wrong; the message names file, key and remedy."""

    users_fault = True


class Unscalable(Exception):
    """A force log, or a set of curves, from which the asked quantity cannot be had."""

    users_fault = True
