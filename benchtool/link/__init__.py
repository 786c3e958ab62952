"""How frames and bytes move between the host and one drive."""

from benchtool.link.interface import BatchLink, Frame, FrameLink, FrameReceiver, Link, LinkCounters

__all__ = ["BatchLink", "Frame", "FrameLink", "FrameReceiver", "Link", "LinkCounters"]
