"""Addresses of links, as `--link` takes them: a scheme, the places that it wants, and options."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from urllib.parse import parse_qsl

from benchtool.errors import UsageError

Check = Callable[[str, str], str]
"""Checks an option by its name and its value; returns a complaint, or an empty string."""


def whole_number(option: str, value: str) -> str:
    """Return a `Check` of numbers without sign."""
    return "" if value.isdecimal() else f"option '{option}' is '{value}', a whole number is expected"


def any_text(_option: str, _value: str) -> str:
    """Return a `Check` that accepts everything."""
    return ""


def did_you_mean(name: str, names: Sequence[str]) -> str:
    """`; did you mean 'x'?` where one of the names is like `name`; empty if none is."""
    close = difflib.get_close_matches(name, names, n=1)
    return f"; did you mean '{close[0]}'?" if close else ""


def one_of(choices: Sequence[str]) -> str:
    """Return the choices as an enumeration in words."""
    return " or ".join([", ".join(choices[:-1]), choices[-1]] if len(choices) > 1 else choices)


@dataclass(frozen=True)
class AddressSyntax:
    """How the addresses of one wire are spelled.

    `places` are the parts after the scheme, separated by colons, the first of which must not be empty;
    `example` are options as the help shows them, `remark` is what the help says besides.
    """

    scheme: str
    places: tuple[str, ...] = ()
    options: Mapping[str, Check] = field(default_factory=dict)
    example: str = ""
    remark: str = ""

    @property
    def spelling(self) -> str:
        """As the help shows it."""
        options = f"?{self.example}" if self.example else ""
        return f"'{':'.join((self.scheme, *self.places))}{options}'"


@dataclass(frozen=True)
class Address:
    """An address whose syntax has been checked."""

    url: str
    scheme: str
    place: tuple[str, ...]
    options: Mapping[str, str]

    @classmethod
    def parse(cls, url: str, syntaxes: Sequence[AddressSyntax]) -> Address:
        """Return the address that `url` spells.

        Raises:
            UsageError: it is of none of these syntaxes, or an option is unknown or wrong.
        """
        # The URL of a port may have options of its own before ours.
        head, _, query = url.rpartition("?") if "?" in url else (url, "", "")
        scheme, colon, rest = head.partition(":")
        syntax = next((each for each in syntaxes if each.scheme == scheme), None)
        place = tuple(rest.split(":", max(0, len(syntax.places) - 1))) if syntax and colon else ()
        if syntax is None or len(place) != len(syntax.places) or (place and not place[0]):
            known = one_of([f"{each.spelling}{each.remark}" for each in syntaxes])
            meant = did_you_mean(scheme, [each.scheme for each in syntaxes]) if syntax is None else ""
            raise UsageError(f"link '{url}' is not known: use {known}{meant}")
        options = dict(parse_qsl(query, keep_blank_values=True))
        for key, value in options.items():
            if key not in syntax.options:
                names = ", ".join(sorted(syntax.options))
                meant = did_you_mean(key, list(syntax.options))
                raise UsageError(f"link '{url}': unknown option '{key}', known are {names}{meant}")
            if complaint := syntax.options[key](key, value):
                raise UsageError(f"link '{url}': {complaint}")
        return cls(url, scheme, place, options)

    @property
    def without_options(self) -> str:
        """The scheme and the places."""
        return ":".join((self.scheme, *self.place))

    def number(self, option: str) -> int | None:
        """Return the value of an option that is a whole number; None if it is not given."""
        return int(self.options[option]) if option in self.options else None

    def node_id(self, default: int) -> int:
        """Return the node that the address names, else `default`.

        Raises:
            UsageError: it is not 1 to 126; 127 is the host itself.
        """
        node_id = int(self.options.get("node", default))
        if not 1 <= node_id <= 126:
            raise UsageError(f"node id {node_id} is outside 1 to 126: choose the drive's node id")
        return node_id
