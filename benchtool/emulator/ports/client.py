"""Clients of a wire, who may connect and disconnect."""

from __future__ import annotations

from dataclasses import dataclass


class HungUp(ConnectionError):
    """The client has closed its end. Another may come: the port can be read on."""


@dataclass(frozen=True)
class Traffic:
    """Frames of one wire since power-up, as the drive counts them."""

    received: int
    sent: int
    dropped: int
    """Malformed ones of the host's, and those of the drive's that the host did not fetch in time."""
