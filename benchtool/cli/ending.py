"""How a command ends: what went wrong as one line each on standard error, and an exit code.

What the system refuses (no space, read-only, no reader, not permitted) is told in a line. A defect of
benchtool is none of these and shows itself with its traceback.
"""

from __future__ import annotations

import errno
import functools
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Final, NoReturn, ParamSpec

import typer

from benchtool.errors import BenchError, EnvironmentFailure

INTERRUPTED: Final = 130
_CONTROLS: Final = {code: f"\\x{code:02x}" for code in (*range(32), *range(127, 160)) if code not in (9, 10)}
_REMEDIES: Final = {
    errno.ENOSPC: "make space there, or write to another place",
    errno.EDQUOT: "make space there, or write to another place",
    errno.EROFS: "write to another place",
    errno.EACCES: "change its permissions, or choose another place",
    errno.EPERM: "change its permissions, or choose another place",
    errno.EPIPE: "its reader has gone: have it read to the end",
    errno.EMFILE: "close other programs or raise the limit of open files (ulimit -n)",
    errno.ENFILE: "close other programs or raise the limit of open files",
}

Arguments = ParamSpec("Arguments")


def reporting(verb: Callable[Arguments, int], *, enables: bool = False) -> Callable[Arguments, None]:
    """`verb`, which may have enabled the drive, with its failures as one line each and as an exit code."""
    interrupted = "interrupted; the drive was left disabled" if enables else "interrupted"

    @functools.wraps(verb)
    def command(*args: Arguments.args, **kwargs: Arguments.kwargs) -> None:
        try:
            code = verb(*args, **kwargs)
            sys.stdout.flush()
        except BenchError as error:
            code = tell(str(error), error)
        except KeyboardInterrupt as interrupt:
            tell(interrupted, interrupt)
            code = INTERRUPTED
        except OSError as failure:
            code = tell_refused(failure)
        raise typer.Exit(code)

    return command


def run_to_the_end(app: Callable[[], object]) -> NoReturn:
    """Run the command line, and end the process with its exit code, whatever its streams can take."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever began this process
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 # for the rest of the process
    try:
        app()
        code: int | str | None = 0
    except SystemExit as end:
        code = end.code
    except OSError as failure:
        code = tell_refused(failure)
    try:
        sys.stdout.flush()
    except OSError as failure:
        code = tell_refused(failure)
    try:
        sys.stderr.flush()  # a library's note, which the interpreter would make an exit code of 120
    except OSError:
        _silence_broken_streams()
    raise SystemExit(code)


def printable(text: str) -> str:
    """Text that comes from outside, such that a terminal shows it and obeys none of it."""
    return text.translate(_CONTROLS)


def tell(text: str, failure: BaseException) -> int:
    """Tell of a failure and of its notes; its exit code."""
    with suppress(OSError):  # then there is nobody to be told
        for line in (text, *getattr(failure, "__notes__", ())):
            sys.stderr.write(f"benchtool: {printable(line)}\n")
        sys.stderr.flush()
    return failure.exit_code if isinstance(failure, BenchError) else EnvironmentFailure.exit_code


def tell_refused(failure: OSError) -> int:
    """Tell what the system has refused; the exit code of that."""
    _silence_broken_streams()
    # What this project writes by name says so itself; what has no name is a stream of this process.
    place = "standard output" if failure.filename is None else f"'{failure.filename}'"
    remedy = _REMEDIES.get(failure.errno or 0, "check that it is there, free and permitted")
    reason = failure.strerror or str(failure) or type(failure).__name__
    return tell(f"cannot use {place}: {reason}; {remedy}", failure)


def _silence_broken_streams() -> None:
    """Have what is left for a stream that takes no more go nowhere, so that the interpreter ends in peace."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
