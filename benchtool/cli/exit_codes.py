"""Exit codes of commands, and errors as one line each on standard error.

Errors of the operating system (no space, read-only, no reader, not permitted) are one line too. A defect of
benchtool shows its traceback.
"""

from __future__ import annotations

import atexit
import errno
import functools
import gc
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, Final, NoReturn, ParamSpec

import typer

from benchtool.errors import BenchError, EnvironmentFailure

INTERRUPTED: Final = 130
OBJECTS: Final = 300_000  # made between two searches for rubbish: what is imported makes hardly any
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


def with_exit_code(verb: Callable[Arguments, int], *, enables: bool = False) -> Callable[Arguments, None]:
    """Wrap `verb`, which may have enabled the drive: print its failures as one line each and return an exit
    code."""
    interrupted = "interrupted; the drive was left disabled" if enables else "interrupted"

    @functools.wraps(verb)
    def command(*args: Arguments.args, **kwargs: Arguments.kwargs) -> None:
        try:
            code = verb(*args, **kwargs)
            sys.stdout.flush()
        except BenchError as error:
            code = print_error(str(error), error)
        except KeyboardInterrupt as interrupt:
            print_error(interrupted, interrupt)
            code = INTERRUPTED
        except OSError as failure:
            code = print_os_error(failure)
        raise typer.Exit(code)

    return command


def run_to_the_end(app: Callable[[], object]) -> NoReturn:
    """Run the command line, and end the process with its exit code, even if its streams are broken."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # the parent process may have closed it
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 # for the rest of the process
    gc.set_threshold(OBJECTS)
    # Matrices here are small: further threads of linear algebra wait for each other, and take the processor.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    # pydantic looks through all installed packages for plug-ins before it checks a document.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    try:
        app()
        code: int | str | None = 0
    except SystemExit as end:
        code = end.code
    except OSError as failure:
        code = print_os_error(failure)
    try:
        sys.stdout.flush()
    except OSError as failure:
        code = print_os_error(failure)
    try:
        sys.stderr.flush()  # output of a library, for which the interpreter would exit with 120
    except OSError:
        _silence_broken_streams()
    gc.freeze()  # the interpreter would look for rubbish among all that was imported, a tenth of a short run
    raise SystemExit(code)


def end_quickly(main: Callable[[], NoReturn]) -> NoReturn:
    """Run `main`, and end the process with its exit code.

    The interpreter would take apart all that was imported, a twentieth of a short run. It is left to the
    operating system, after all that was registered for the end has run; where something was registered
    before, as by a tool that measures the process, the interpreter ends as ever.
    """
    codes: list[int] = []

    def leave() -> None:
        for stream in (sys.stdout, sys.stderr) if codes else ():
            with suppress(OSError, ValueError):
                stream.flush()
        for code in codes:
            os._exit(code & 0xFF)

    if getattr(atexit, "_ncallbacks", lambda: 1)() == 0:
        atexit.register(leave)  # what is registered first runs last
    try:
        main()
    except SystemExit as end:
        if end.code is None or isinstance(end.code, int):
            codes.append(end.code or 0)
        raise


@contextmanager
def ended_by_hand() -> Iterator[Callable[[], bool]]:
    """Within a `with` block, the first Ctrl-C or SIGTERM asks for an end; a second one interrupts.

    What it gives tells whether one has come.
    """
    asked = False
    before: dict[int, Any] = {}

    def ask(number: int, frame: FrameType | None) -> None:
        nonlocal asked
        if not asked:
            asked = True
        elif callable(before[number]):
            before[number](number, frame)

    with suppress(ValueError):  # another thread than the main one gets no signals
        for number in (int(signal.SIGINT), int(signal.SIGTERM)):
            before[number] = signal.signal(number, ask)
    try:
        yield lambda: asked
    finally:
        for number, handler in before.items():
            if signal.getsignal(number) is ask:  # a second one has perhaps set its own
                signal.signal(number, handler)


def printable(text: str) -> str:
    """Return the text that comes from outside, with control characters escaped."""
    return text.translate(_CONTROLS)


def print_error(text: str, failure: BaseException) -> int:
    """Print a failure and its notes on standard error; return its exit code."""
    with suppress(OSError):  # standard error is closed: nothing can be printed
        for line in (text, *getattr(failure, "__notes__", ())):
            sys.stderr.write(f"benchtool: {printable(line)}\n")
        sys.stderr.flush()
    return failure.exit_code if isinstance(failure, BenchError) else EnvironmentFailure.exit_code


def print_os_error(failure: OSError) -> int:
    """Print an error of the operating system; return its exit code."""
    _silence_broken_streams()
    # Files are named in their own errors; an error without a name is of a stream of this process.
    place = "standard output" if failure.filename is None else f"'{failure.filename}'"
    remedy = _REMEDIES.get(failure.errno or 0, "check that it is there, free and permitted")
    reason = failure.strerror or str(failure) or type(failure).__name__
    return print_error(f"cannot use {place}: {reason}; {remedy}", failure)


def _silence_broken_streams() -> None:
    """Redirect broken streams to the null device, so that the interpreter can exit."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
