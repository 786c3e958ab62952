"""Writes what is generated from `objects.toml`: `drive.eds`, `drive_objects.h` and `objects.md`; and, of the
serial protocol, `serial_vectors.json`.

python -m firmware_protocol.generate            write the files
python -m firmware_protocol.generate --check    write nothing; exit 1 and name each file that is stale
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchtool.protocol.dictionary.objects import ObjectTable, table_from_toml
from firmware_protocol import c_header, eds_file, reference_page, vectors

FOLDER = Path(__file__).resolve().parent


def generated(table: ObjectTable) -> Mapping[str, str]:
    """Return the text of every generated file by its name; the same table gives the same text, always."""
    return {
        "drive.eds": eds_file.render(table),
        "drive_objects.h": c_header.render(table),
        "objects.md": reference_page.render(table),
        "serial_vectors.json": vectors.render(),
    }


def main(arguments: Sequence[str] | None = None, folder: Path = FOLDER) -> int:
    """Write or check the files in `folder`, from the table beside this module; the process's exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m firmware_protocol.generate", description="Generate the files of the object table."
    )
    parser.add_argument("--check", action="store_true", help="write nothing, exit 1 if a file is stale")
    check = parser.parse_args(arguments).check
    table = table_from_toml(tomllib.loads((FOLDER / "objects.toml").read_text(encoding="utf-8")))
    stale = [
        (folder / name, text)
        for name, text in generated(table).items()
        if not (folder / name).is_file() or (folder / name).read_bytes() != text.encode()
    ]
    for path, text in stale:
        if check:
            sys.stderr.write(f"{path.name} is stale: run python -m firmware_protocol.generate\n")
        else:
            path.write_bytes(text.encode())
    return 1 if check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
