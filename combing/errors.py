"""What a user is told when an input is at fault, and how the command line tells it."""


class UserError(Exception):
    """An input is wrong; one line says which, where, the value found and what would be right.

    The command line prints the message and exits with 2. Any other exception is a defect of
    ours and exits with 1.
    """
