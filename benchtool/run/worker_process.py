"""How a process begins that runs cases for another."""

from __future__ import annotations

import gc

from benchtool.link import import_can_without_mdf


def begin_worker(*gc_threshold: int) -> None:
    """Set up what its parent has, before anything large is imported."""
    gc.set_threshold(*gc_threshold)
    import_can_without_mdf()
