"""The one error for what comes from outside: command line, files, cache, checkpoints."""


class InputError(ValueError):
    """Bad input, told in one line: the file or argument, what was expected, what came.

    Raised where something enters the program, never inside it. The command line prints the message without a
    traceback and ends with exit status 1.
    """
