"""How frames and bytes move between the host and one drive."""

from benchtool.link.interface import Frame, FrameReceiver, Link, LinkCounters

__all__ = ["Frame", "FrameReceiver", "Link", "LinkCounters"]
