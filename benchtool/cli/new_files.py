"""Files that a command writes for a person to go on with."""

from __future__ import annotations

import sys
from pathlib import Path

from benchtool.errors import UsageError


def write_new(file: Path | None, text: str, *, force: bool, quiet: bool) -> None:
    """Write a text file, or print it where no file is named and standard output is not for a document.

    Raises:
        UsageError: the file exists and `force` does not allow to replace it, or its name does not end in
            .toml.
        RecordingError: it cannot be written.
    """
    if file is None:
        if not quiet:
            sys.stdout.write(text)
        return
    if file.suffix != ".toml":
        raise UsageError(f"{file}: a name that ends in .toml is expected, by which it is found again")
    if file.exists() and not force:
        raise UsageError(f"{file} exists: give another name, or --force to replace it")
    from benchtool.recording import write_whole

    write_whole(file, text.encode("utf-8"))
