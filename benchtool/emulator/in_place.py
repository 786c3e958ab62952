"""Records of the kernel by their address: what a bench has is stored once, and passed on as one pointer.

A NamedTuple of compiled code is a value. Passed to a function it is as many arguments as it has numbers, with
those of all its parts: a hundred for a machine, unpacked and packed again wherever it is passed on, which
costs more of the compiler's time than the equations, and at each call a hundred stores. `in_place` keeps it
in the memory of the function that calls that; its fields are read from there as those of the value are, and
a part of it is in place as well.

    machine = in_place(machine)       # by its address from here on
    ...
    other = changed(value_of(machine))   # a value again

In Python all of them are the records that they are; `in_place_types` tells the compiler.
"""

from __future__ import annotations

from typing import TypeVar

Record = TypeVar("Record")


def in_place(record: Record) -> Record:
    """Return a record by its address, in the memory of the function that asks for it.

    That is there as long as this function runs, so that it is not to be returned.
    """
    return record


def value_of(record: Record) -> Record:
    """Return a record in place as a value."""
    return record


def renewed(part: object, before: Record, now: Record) -> Record:
    """Return `before`, a record in place, or where there is `part` the value `now` in the place of it."""
    return before if part is None else now
