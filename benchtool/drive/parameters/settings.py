"""Parameter files applied to a drive: valid settings, and differences."""

from __future__ import annotations

from dataclasses import dataclass

from benchtool.drive.identity import Identity, described, differs
from benchtool.drive.parameters.file import ParameterFile
from benchtool.drive.parameters.migration import Migrations
from benchtool.errors import ParameterFileError, ValueRefused
from benchtool.protocol.dictionary import Dictionary, Value, Variable, toml_key, variable_of

# Writing these changes the drive's address, so that the host loses it. LSS does so too, without objects.
_ADDRESS_INDEX = 0x100B
_ADDRESS_NAMES = frozenset({"node_id", "bit_rate"})


@dataclass(frozen=True)
class Difference:
    """A key whose values differ; None where one side lacks it."""

    key: str
    a: int | float | str | None
    b: int | float | str | None


def settings(
    file: ParameterFile,
    source: str,
    dictionary: Dictionary,
    identity: Identity,
    migrations: Migrations,
    *,
    with_address: bool = False,
) -> dict[str, Value]:
    """Return the values by name as a drive is to take them, in the dictionary's order, checked against its
    limits.

    Args:
        file: as read from `source`.
        source: its name, for messages.
        dictionary: the drive's.
        identity: of the drive that answers.
        migrations: rules for files of earlier dictionaries.
        with_address: keep node id and bit rate, which are left out otherwise.

    Raises:
        ParameterFileError: another product's or another dictionary's, a key is unknown or no parameter, or a
            value is outside its limits.
    """
    provenance = file.drive
    if differs(provenance.vendor_id, identity.vendor_id) or differs(
        provenance.product_code, identity.product_code
    ):
        raise ParameterFileError(
            f"{source} is of {described(provenance.vendor_id, provenance.product_code)}; the drive is "
            f"{described(identity.vendor_id, identity.product_code)}: load a file of such a drive"
        )
    try:
        migrated = file.migrated(dictionary.hash, migrations)
    except ParameterFileError as reason:
        raise ParameterFileError(f"{source}: {reason}") from None
    if migrated is None:
        raise _of_another_dictionary(file, source, dictionary)
    found: dict[str, Value] = {}
    for key, value in migrated.parameters.items():
        try:
            found[_parameter_of(dictionary, key, value).name] = value
        except ValueRefused as reason:
            raise ParameterFileError(f"{source}: {reason}") from None
    return {
        variable.name: found[variable.name]
        for variable in dictionary
        if variable.name in found and (with_address or not is_address(variable))
    }


def is_address(variable: Variable) -> bool:
    """Return whether it is an address of the drive on the bus: 0x100B, or a node id or bit rate by name."""
    return variable.index == _ADDRESS_INDEX or variable.name in _ADDRESS_NAMES


def as_held(file: ParameterFile, dictionary: Dictionary) -> ParameterFile:
    """Return file with each value as a drive would read it back: rounded to its type, an enumeration by name.

    What the drive cannot hold stays as it is.
    """
    variables = {toml_key(variable): variable for variable in dictionary}

    def held(key: str, value: int | float | str) -> int | float | str:
        try:
            kept = variables[key].decode(variables[key].encode(value))
        except (KeyError, ValueRefused):
            return value
        return value if isinstance(kept, bytes) else kept

    values = {key: held(key, value) for key, value in file.parameters.items()}
    return file.model_copy(update={"parameters": values})


def aligned(
    a: ParameterFile, b: ParameterFile, migrations: Migrations
) -> tuple[ParameterFile, ParameterFile]:
    """Return the two by the keys of the later dictionary, where a rule leads from one to the other.

    Raises:
        ParameterFileError: a value does not fit the rule for it.
    """
    if (migrated := a.migrated(b.drive.dictionary_hash, migrations)) is not None:
        return migrated, b
    return a, b.migrated(a.drive.dictionary_hash, migrations) or b


def compare(a: ParameterFile, b: ParameterFile) -> tuple[Difference, ...]:
    """Return where two files differ: product and dictionary, then each key in the order of `a`, then of `b`.

    Dates, names, versions and serial numbers do not count.
    """
    left, right = _compared(a), _compared(b)
    return tuple(
        Difference(key, left.get(key), right.get(key))
        for key in dict.fromkeys((*left, *right))
        if left.get(key) != right.get(key)
    )


def _compared(file: ParameterFile) -> dict[str, int | float | str]:
    provenance = file.drive
    head = {
        "drive.vendor_id": provenance.vendor_id,
        "drive.product_code": provenance.product_code,
        "drive.dictionary_hash": provenance.dictionary_hash,
    }
    shown = {key: f"0x{value:08X}" for key, value in head.items() if value is not None}
    return {**shown, **file.parameters}


def _parameter_of(dictionary: Dictionary, key: str, value: Value) -> Variable:
    variable = variable_of(dictionary, key)
    if variable.role != "parameter" or not variable.writable:
        raise ValueRefused(
            f"'{key}' is a {variable.role} with access '{variable.access}', a writable parameter is "
            f"expected: remove the line"
        )
    variable.encode(value)
    return variable


def _of_another_dictionary(file: ParameterFile, source: str, dictionary: Dictionary) -> ParameterFileError:
    known = {toml_key(variable) for variable in dictionary}
    unknown = [key for key in file.parameters if key not in known]
    keys = f"it does not know {', '.join(unknown)}" if unknown else "it knows every key of the file"
    return ParameterFileError(
        f"{source} is of dictionary 0x{file.drive.dictionary_hash:08X} (firmware "
        f"{file.drive.firmware_version or 'unknown'}), the drive speaks 0x{dictionary.hash:08X} and no rule "
        f"leads there; {keys}: check each value and its unit, then write the drive's "
        f"dictionary_hash into the file"
    )
