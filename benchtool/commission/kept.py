"""A commissioning that is over, read from its folder: the document, and the bundles of its steps."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from benchtool.commission.recorder import DETAILS, step_bundles
from benchtool.commission.results import StepVerdict
from benchtool.errors import RecordingError, UsageError
from benchtool.recording import (
    COMMISSIONING,
    MANIFEST,
    Bundle,
    read_manifest,
    read_sealed_json,
    require_listed,
)

DOCUMENT: Final = COMMISSIONING


@dataclass(frozen=True)
class KeptCommissioning:
    """What a commissioning wrote: the document as `benchtool.commission.document` made it, and the bundles of
    its steps in their order."""

    document: dict[str, Any]
    bundles: tuple[Bundle, ...]

    @property
    def passed(self) -> bool:
        """Whether every step passed, and nothing was found that is not as it should be."""
        return bool(self.document["verdict"] == StepVerdict.PASS)


def read_commissioning(folder: Path) -> KeptCommissioning | None:
    """Return the commissioning in a folder; None where it holds another recording, or none.

    Raises:
        UsageError: it was cut short, and came to no result.
        RecordingError: a file of it is missing, or is not what was written.
    """
    if not (folder / DOCUMENT).is_file():
        if not _has_steps(folder):
            return None
        raise UsageError(
            f"{folder} holds the steps of a commissioning and no {DOCUMENT}, which is written at its end: go "
            f"on with 'benchtool commission --resume {folder}', or give the folder of one of its steps"
        )
    require_listed(folder, DOCUMENT)
    document, _ = read_sealed_json(folder / DOCUMENT)
    bundles = step_bundles(folder)
    recorded = {bundle.directory.name for bundle in bundles}
    for name, step in document["steps"].items():
        if step["verdict"] == StepVerdict.PASS and name not in recorded:
            raise RecordingError(
                f"{folder / name} is missing, the recording of a step that passed by {DOCUMENT}: restore it "
                f"from a copy"
            )
    return KeptCommissioning(document, bundles)


def _has_steps(folder: Path) -> bool:
    """Return whether a bundle in a folder is that of a step, damaged ones aside."""
    for path in folder.glob(f"*/{MANIFEST}"):
        try:
            manifest, _ = read_manifest(path.parent)
        except RecordingError:
            continue
        if DETAILS in manifest.details:
            return True
    return False
