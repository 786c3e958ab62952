"""How frames and bytes move between the host and one drive."""

from benchtool.link.interface import Alarm, BatchLink, Frame, FrameLink, FrameReceiver, Link, LinkCounters

__all__ = ["Alarm", "BatchLink", "Frame", "FrameLink", "FrameReceiver", "Link", "LinkCounters"]
