"""The catalogue of analyses, imported when a plan needs it: a slip of the pen elsewhere in a plan does not
wait for the third of a second that it takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchtool.analysis.catalogue import Catalogue


def catalogue() -> Catalogue:
    """As `benchtool.analysis.catalogue.catalogue`, imported by the first call."""
    from benchtool.analysis import catalogue

    return catalogue.catalogue()
