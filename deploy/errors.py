"""What the command reports in one line."""


class CommandError(Exception):
    """The command could not do it; exit status 1."""

    exit_code = 1


class UsageError(CommandError):
    """The user asked for something that does not exist or makes no sense; exit status 2."""

    exit_code = 2
