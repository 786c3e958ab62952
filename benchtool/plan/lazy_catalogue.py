"""The catalogue of analyses, imported when a plan needs it: other errors in a plan are reported without the
third of a second that the import takes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from benchtool.analysis import Catalogue


def catalogue() -> Catalogue:
    """As `benchtool.analysis.catalogue.catalogue`, imported by the first call."""
    from benchtool.analysis import catalogue as shipped

    return shipped()
