"""The program's entry: `python -m lssd_learn`, the console script `lssd` and train.py all begin here.

To import what it needs takes seconds; Ctrl-C ends those in one line too. Help, the version and the refusal of what is
misspelt need none of it.
"""

import os
import signal
import sys
import threading

import lssd_learn
from lssd_learn.command.help import ASKED, tell
from lssd_learn.errors import InputError


def main() -> None:
    """Run the command line, see `app.main`; `lssd measure …` is a command of its own."""
    if sys.argv[1:2] == ["measure"]:
        from lssd_learn.command import measure

        sys.exit(measure.main(sys.argv[2:]))
    if set(ASKED) & set(sys.argv[1:]):
        _help()
        return
    if "--version" in sys.argv[1:]:
        print(f"lssd_learn {lssd_learn.__version__}")
        return
    if {"--shell-completion", "-sc"} & set(sys.argv[1:]):
        from lssd_learn.command import completion

        completion.complete()
        return
    in_main = threading.current_thread() is threading.main_thread()  # signals are its business alone
    before = signal.signal(signal.SIGINT, _interrupted) if in_main else None
    if before is signal.SIG_IGN:  # whoever started this wants it so
        signal.signal(signal.SIGINT, before)
    from lssd_learn.command.understood import understood

    try:
        arguments = understood(sys.argv[1:])
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    from lssd_learn import app

    if in_main and before is not None:
        signal.signal(signal.SIGINT, before)
    app.main(arguments)


def _help() -> None:
    try:
        print(tell(sys.argv[1:]), flush=True)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    except BrokenPipeError:  # `lssd --help | head` has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _interrupted(*_) -> None:
    # An exception would end in the middle of somebody's import, and in a traceback.
    if os.environ.get("LOCAL_RANK", "0") == "0":
        os.write(sys.stderr.fileno(), b"error: interrupted before anything began\n")
    os._exit(130)


if __name__ == "__main__":
    main()
