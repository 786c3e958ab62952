"""How frames and bytes move between the host and one drive."""

from benchtool.link.interface import Link, LinkCounters

__all__ = ["Link", "LinkCounters"]
