"""The one place where the wire decides how process data travel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from benchtool.errors import ValueRefused
from benchtool.link import BatchLink, FrameLink
from benchtool.protocol.telemetry import most_channels
from benchtool.telemetry.batch_source import BatchSource
from benchtool.telemetry.node import Node
from benchtool.telemetry.pdo_source import PdoSource
from benchtool.telemetry.source import Source


def fitting(node: Node, channels: Sequence[str]) -> tuple[str, ...]:
    """Of these signals those that the drive has, the first ones, as many as a record over its link holds."""
    known = tuple(name for name in channels if name in node.dictionary)
    return known[: most_channels(node.link.node_id)] if isinstance(node.link, FrameLink) else known


def stream_source(
    node: Node, channels: Sequence[str], rate_Hz: float, after: Source[Any] | None = None
) -> Source[Any]:
    """A stream of these signals over the drive's link; nothing is set up yet.

    What travels differs by wire and stays between the source's receiver and its `feed`. `after` is the source
    that this one goes on for, which knows what the drive was set up for before.

    Raises:
        ValueRefused: the drive cannot stream this.
    """
    link = node.link
    if isinstance(link, BatchLink):
        return BatchSource(node, link, channels, rate_Hz)
    if isinstance(link, FrameLink):
        return PdoSource(node, link, channels, rate_Hz, after if isinstance(after, PdoSource) else None)
    raise ValueRefused("this link carries no process data: use another link")
