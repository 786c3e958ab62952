"""The wires that there are: the only place that lists them.

A package that is installed beside this one adds wires of its own by an entry point of the group
`benchtool.wires`, whose object is a `Wire`. Wires of this package are found first.
"""

from __future__ import annotations

from collections.abc import Iterator

from benchtool.bench.wires import canopen, replay, serial
from benchtool.bench.wires.address import Address, Form, one_of
from benchtool.bench.wires.emulated import emulated
from benchtool.bench.wires.wire import FarEnd, Offer, Wire
from benchtool.errors import EnvironmentFailure, UsageError

GROUP = "benchtool.wires"
_DEFAULT_CARRIER = "can"


def wires() -> Iterator[Wire]:
    """All of them. Installed ones are looked for only if the iteration gets so far.

    Raises:
        EnvironmentFailure: an installed one cannot be loaded.
    """
    yield from _BUILT_IN
    yield from _installed()


def parse(url: str) -> Address:
    """The address that a URL spells.

    Raises:
        UsageError: it is of no known form, or an option is unknown or wrong.
    """
    scheme = url.partition("?")[0].partition(":")[0]
    form = next((wire.form for wire in wires() if wire.form and wire.form.scheme == scheme), None)
    return Address.parse(url, [form] if form else _forms(wires()))


def wire_of(address: Address) -> Wire:
    """The wire whose form an address has."""
    return next(wire for wire in wires() if wire.form and wire.form.scheme == address.scheme)


def carrier(address: Address) -> Wire:
    """What the messages of the drive go over: of an emulated bench the wire that its address names."""
    wire = wire_of(address)
    if wire.far_end is not FarEnd.EMULATED_DRIVE:
        return wire
    name = address.options.get("wire", _DEFAULT_CARRIER)
    return next(each for each in _carriers() if each.name == name)


def far_end(url: str) -> FarEnd:
    """What is at the other end of a link.

    Raises:
        UsageError: it is of no known form.
    """
    return wire_of(parse(url)).far_end


def offer_named(name: str) -> Offer:
    """A way to offer an emulated drive to other programs.

    Raises:
        UsageError: there is none of this name.
    """
    known: list[str] = []
    for wire in wires():
        if name in wire.offers:
            return wire.offers[name]
        known += wire.offers
    raise UsageError(f"an emulated drive offers no '{name}': choose {one_of(known)}")


def links_help() -> str:
    """How links are spelled, those of this package."""
    return f"{one_of([form.spelling for form in _forms(_BUILT_IN)])}."


def channels_help() -> str:
    """How many signals a stream may have, over the wires of this package."""
    limits = [f"{wire.stream.signals} at most over {wire.stream.over}" for wire in _BUILT_IN if wire.stream]
    return f"Signals: {', '.join(limits)}."


def rate_help() -> str:
    """How fast a stream may be, over the wires of this package."""
    limits = [f"{wire.stream.rate} at most over {wire.stream.over}" for wire in _BUILT_IN if wire.stream]
    return f"Records per second: {', '.join(limits)}."


def _carriers() -> Iterator[Wire]:
    return (wire for wire in wires() if wire.host_link is not None)


def _no_carrier(option: str, name: str) -> str:
    """A `Check`."""
    known = []
    for wire in _carriers():
        if wire.name == name:
            return ""
        known.append(wire.name)
    return f"{option} '{name}' is not known, known are {', '.join(known)}"


def _forms(among: Iterator[Wire] | tuple[Wire, ...]) -> list[Form]:
    return [wire.form for wire in among if wire.form is not None]


def _installed() -> Iterator[Wire]:
    from importlib.metadata import entry_points  # takes a third of what a command line has to start

    for entry in entry_points(group=GROUP):
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
