"""Parameter files: the parameters of one drive as TOML, with units in the keys and their provenance."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field, StrictFloat, StrictInt, StrictStr

from benchtool.document import Section, load_document
from benchtool.drive.identity import Identity
from benchtool.drive.parameters.migration import Hash, Migrations
from benchtool.errors import ParameterFileError
from benchtool.file_kinds import FileKind
from benchtool.protocol.dictionary import Dictionary, Variable, toml_key
from benchtool.recording import write_whole

Scalar = StrictInt | StrictFloat | StrictStr
_HEX = ("dictionary_hash", "vendor_id", "product_code", "revision_number")


class Provenance(Section):
    """The drive that the values were read from, and when (ISO 8601)."""

    date: str = ""
    device_name: str = ""
    firmware_version: str = ""
    dictionary_hash: Hash | None = None
    vendor_id: Annotated[int, Field(ge=0)] | None = None
    product_code: Annotated[int, Field(ge=0)] | None = None
    revision_number: Annotated[int, Field(ge=0)] | None = None
    serial_number: Annotated[int, Field(ge=0)] | None = None


class ParameterFile(Section):
    """Values by TOML key, in the unit that the key ends in."""

    drive: Provenance
    parameters: dict[str, Scalar]

    def migrated(self, to_hash: int | None, migrations: Migrations) -> ParameterFile | None:
        """Return the file as the dictionary `to_hash` would state it; None if no rule leads there.

        A drive or a file without a hash is of another vendor, whose dictionaries have no versions.

        Raises:
            ParameterFileError: a value does not fit the rule for it.
        """
        if self.drive.dictionary_hash is None or to_hash is None:
            return self
        chain = migrations.path(self.drive.dictionary_hash, to_hash)
        if chain is None:
            return None
        values: Mapping[str, int | float | str] = self.parameters
        for rule in chain:
            values = rule.apply(values)
        provenance = self.drive.model_copy(update={"dictionary_hash": to_hash})
        return self.model_copy(update={"drive": provenance, "parameters": dict(values)})


def describe(identity: Identity, values: Mapping[str, int | float | str], date: str) -> ParameterFile:
    """Return the parameter file of a drive: who answered, and the snapshot of its parameters.

    Raises:
        ParameterFileError: the drive holds nan or infinity, which a file cannot represent.
    """
    for key, value in values.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise ParameterFileError(
                f"the drive holds '{key}' = {value}, a finite number is expected: set it first"
            )
    provenance = Provenance(
        date=date,
        device_name=identity.device_name or "",
        firmware_version=identity.firmware_version or "",
        dictionary_hash=identity.dictionary_hash,
        vendor_id=identity.vendor_id,
        product_code=identity.product_code,
        revision_number=identity.revision_number,
        serial_number=identity.serial_number,
    )
    return ParameterFile(drive=provenance, parameters=dict(values))


def read_parameter_file(path: Path) -> ParameterFile:
    """Return the file at `path`.

    Raises:
        ParameterFileError: unreadable, not TOML, or not of this form.
    """
    return load_document(path, ParameterFile, ParameterFileError, kind=FileKind.PARAMETERS)


def write_parameter_file(path: Path, text: str) -> None:
    """Write a file atomically: a reader sees the old or the new one.

    Raises:
        RecordingError: it cannot be written.
    """
    write_whole(path, text.encode("utf-8"))


def render(file: ParameterFile, dictionary: Dictionary) -> str:
    """Return the TOML text of a file, every parameter under its description and limits; same values, same
    text."""
    variables = {toml_key(variable): variable for variable in dictionary}
    lines = ["# Parameters of a drive. Write them back with: benchtool params load FILE", "", "[drive]"]
    for key, value in file.drive.model_dump(exclude_none=True).items():
        lines.append(f"{key} = {f'0x{value:08X}' if key in _HEX else _toml(value)}")
    lines += ["", "[parameters]"]
    for key, value in file.parameters.items():
        comment = about(variables[key]) if key in variables else ""
        lines += [*([f"# {comment}"] if comment else []), f"{_key(key)} = {_toml(value)}", ""]
    return "\n".join(lines).rstrip() + "\n"


def about(variable: Variable) -> str:
    """Return the description and limits on one line: `Stator resistance per phase; 0 to 100 ohm`."""
    parts = [re.sub(r"[\x00-\x1f\x7f]", " ", variable.description)] if variable.description else []
    if variable.values is not None:
        parts.append(f"one of {', '.join(variable.values)}")
    elif variable.minimum is not None and variable.maximum is not None:
        parts.append(f"{variable.minimum:.10g} to {variable.maximum:.10g} {variable.unit}".rstrip())
    return "; ".join(parts)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml(key)


def _toml(value: int | float | str) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
