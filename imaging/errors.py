"""What a photograph's owner is told when it cannot be measured."""


class Unmeasurable(Exception):  # noqa: N818 - names the photograph's state, as a lab would say it
    """A photograph, or what it shows, does not allow the measurement asked for.

    The message names the file, the place, what was found and what would be right.
    """

    users_fault = True
