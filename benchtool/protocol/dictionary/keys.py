"""Keys of TOML files for variables: the name and, where there is a unit, the unit appended."""

from __future__ import annotations

import difflib
from pathlib import PurePath

from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary.dictionary import Dictionary
from benchtool.protocol.dictionary.variable import Value, Variable


def toml_key(variable: Variable) -> str:
    """Return the key of a variable: `u_s_V`, `omega_observer_rad_s`, `law`."""
    return f"{variable.name}_{variable.unit.replace('/', '_')}" if variable.unit else variable.name


def variable_of(dictionary: Dictionary, key: str) -> Variable:
    """Return the variable that a key names.

    Raises:
        ValueRefused: no variable has that key.
    """
    variables = list(dictionary)
    for variable in variables:
        if key.startswith(variable.name) and key == toml_key(variable):
            return variable
    near = [variable for variable in variables if key == variable.name or key.startswith(f"{variable.name}_")]
    close = difflib.get_close_matches(key, [toml_key(variable) for variable in variables], n=1)
    hint = "see 'benchtool params list'"
    if near:
        hint = f"write '{toml_key(near[-1])}'"
    elif close:
        hint = f"did you mean '{close[0]}'?"
    raise ValueRefused(f"no parameter '{key}' in {PurePath(dictionary.source).name}: {hint}")


def setting_of(dictionary: Dictionary, key: str, value: Value) -> Variable:
    """Return the variable that a document sets by this key to this value.

    Text is the name of an enumeration's value or that of a string, and not a number in quotes.

    Raises:
        ValueRefused: no variable has that key, or the value is of another type or outside its limits.
    """
    variable = variable_of(dictionary, key)
    if isinstance(value, str) and variable.type.numpy is not None:
        if variable.values is None:
            raise ValueRefused(f"{key} is {value!r}, a number is expected: write it without quotes")
        if value not in variable.values:
            names = ", ".join(variable.values)
            raise ValueRefused(f"{key} is {value!r}, the values are {names}: choose one of these")
    variable.encode(value)
    return variable
