"""The acceptance filter of the SJA1000 in dual filter mode, which the commands M and m of slcan set."""

from __future__ import annotations

from benchtool.protocol import SlcanFrame

ACCEPT_ALL = (0x00000000, 0xFFFFFFFF)
"""Code and mask after power-up (LAWICEL CAN232 manual)."""


def accepts(code: int, mask: int, frame: SlcanFrame) -> bool:
    """Return whether a frame passes one of the two filters (NXP SJA1000 data sheet, 6.4.15.2).

    Args:
        code: acceptance code registers 0 to 3, the first in the highest byte.
        mask: acceptance mask registers, likewise; a bit that is set makes the bit of the code irrelevant.
    """
    halves = ((code >> 16, mask >> 16), (code & 0xFFFF, mask & 0xFFFF))
    if frame.extended:  # both filters compare the identifier's upper 16 bits
        return any(_agree(frame.can_id >> 13, half, ignored) for half, ignored in halves)
    # Identifier, remote bit and, in the first filter only, the first data byte: its lower half is compared
    # with the lower half of the last code register.
    head = frame.can_id << 5 | frame.remote << 4
    first, second = halves
    if _agree(head, second[0] & 0xFFF0, second[1] | 0x000F):
        return True
    if not frame.data:
        return _agree(head, first[0] & 0xFFF0, first[1] | 0x000F)
    wanted, ignored = first[0] << 4 | second[0] & 0xF, first[1] << 4 | second[1] & 0xF
    return _agree(head << 4 | frame.data[0], wanted, ignored)


def _agree(value: int, wanted: int, ignored: int) -> bool:
    return not (value ^ wanted) & ~ignored
