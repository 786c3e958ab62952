"""The registry of wires.

A package that is installed beside this one adds wires of its own by an entry point of the group
`benchtool.wires`, whose object is a `Wire`. Wires of this package are found first.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from functools import cache
from typing import TYPE_CHECKING

from benchtool.bench.wires import canopen, replay, serial
from benchtool.bench.wires.address import Address, AddressSyntax, did_you_mean, one_of
from benchtool.bench.wires.emulated import emulated
from benchtool.bench.wires.wire import FarEnd, Offer, Wire
from benchtool.errors import EnvironmentFailure, UsageError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP = "benchtool.wires"
_DEFAULT_CARRIER = "can"


def wires() -> Iterator[Wire]:
    """Yield all of them. Installed ones are looked for only if the iteration gets so far.

    Raises:
        EnvironmentFailure: an installed one cannot be loaded.
    """
    yield from _BUILT_IN
    yield from _installed()


def parse(url: str) -> Address:
    """Return the address that a URL spells.

    Raises:
        UsageError: it is of no known syntax, or an option is unknown or wrong.
    """
    scheme = url.partition("?")[0].partition(":")[0]
    syntax = next((wire.syntax for wire in wires() if wire.syntax and wire.syntax.scheme == scheme), None)
    return Address.parse(url, [syntax] if syntax else _syntaxes(wires()))


def wire_of(address: Address) -> Wire:
    """Return the wire whose syntax an address has."""
    return next(wire for wire in wires() if wire.syntax and wire.syntax.scheme == address.scheme)


def carrier(address: Address) -> Wire:
    """Return wire that carries the messages of the drive; of an emulated bench the one its address names."""
    wire = wire_of(address)
    if wire.far_end is not FarEnd.EMULATED_DRIVE:
        return wire
    name = address.options.get("wire", _DEFAULT_CARRIER)
    return next(each for each in _carriers() if each.name == name)


def far_end(url: str) -> FarEnd:
    """Return what is at the other end of a link.

    Raises:
        UsageError: it is of no known syntax.
    """
    return wire_of(parse(url)).far_end


def offer_named(name: str) -> Offer:
    """Return a way to offer an emulated drive to other programs.

    Raises:
        UsageError: there is none of this name.
    """
    known: list[str] = []
    for wire in wires():
        if name in wire.offers:
            return wire.offers[name]
        known += wire.offers
    raise UsageError(
        f"an emulated drive offers no '{name}': choose {one_of(known)}{did_you_mean(name, known)}"
    )


def links_help() -> str:
    """Return how links are spelled, those of this package."""
    return f"{one_of([syntax.spelling for syntax in _syntaxes(_BUILT_IN)])}."


def channels_help() -> str:
    """Return how many signals a stream may have, over the wires of this package."""
    limits = [f"{wire.stream.signals} at most over {wire.stream.over}" for wire in _BUILT_IN if wire.stream]
    return f"Signals: {', '.join(limits)}."


def rate_help() -> str:
    """Return how fast a stream may be, over the wires of this package."""
    limits = [f"{wire.stream.rate} at most over {wire.stream.over}" for wire in _BUILT_IN if wire.stream]
    return f"Records per second: {', '.join(limits)}."


def _carriers() -> Iterator[Wire]:
    return (wire for wire in wires() if wire.host_link is not None)


def _no_carrier(option: str, name: str) -> str:
    """Return a `Check`."""
    known = []
    for wire in _carriers():
        if wire.name == name:
            return ""
        known.append(wire.name)
    return f"{option} '{name}' is not known, known are {', '.join(known)}{did_you_mean(name, known)}"


def _syntaxes(among: Iterator[Wire] | tuple[Wire, ...]) -> list[AddressSyntax]:
    return [wire.syntax for wire in among if wire.syntax is not None]


def installed_entries() -> Iterable[EntryPoint]:
    """Return the entry points of other packages' wires."""
    return _entries_on(tuple(sys.path))


@cache
def _entries_on(_path: tuple[str, ...]) -> Iterable[EntryPoint]:
    from importlib.metadata import entry_points  # takes a third of what a command line has to start

    return entry_points(group=GROUP)


def _installed() -> Iterator[Wire]:
    for entry in installed_entries():
        try:
            wire = entry.load()
        except (Exception, SystemExit) as reason:  # another package raises anything
            raise EnvironmentFailure(
                f"the wire '{entry.name}' ({entry.value}) cannot be loaded: {reason!r}; repair or remove the "
                f"package that brings it"
            ) from reason
        if not isinstance(wire, Wire):
            raise EnvironmentFailure(
                f"the entry point '{entry.name}' ({entry.value}) of {GROUP} is a {type(wire).__name__}, a "
                f"Wire is expected: repair or remove the package that brings it"
            )
        yield wire


_BUILT_IN = (
    emulated(carrier, _no_carrier),
    canopen.WIRE,
    serial.WIRE,
    replay.WIRE,
)
