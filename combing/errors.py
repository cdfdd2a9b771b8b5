"""What a user is told when an input is at fault, and how the command line knows it."""

SOME_LEFT_OUT = 3  # exit code: done, but for parts whose input is at fault


class UserError(Exception):
    """An input is wrong; one line says which, where, the value found and what would be right.

    The command line prints the message and exits with 2. Any other exception is a defect of
    ours and exits with 1.
    """

    users_fault = True


def is_users_fault(error: Exception) -> bool:
    """Tell a wrong input from a defect of ours.

    The instruments raise exceptions of their own (``instron.Unreadable``, ...) and know nothing of
    this package, so each marks itself with a class attribute ``users_fault = True``.
    """
    return isinstance(error, OSError) or getattr(error, "users_fault", False)
