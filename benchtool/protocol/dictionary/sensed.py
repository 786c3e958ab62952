"""The channels that a sensor reads: those that `[bench.channels]` may state."""

from __future__ import annotations

from typing import Final

from pydantic import ConfigDict

from benchtool.document import Section, load_document
from benchtool.errors import ProfileError
from benchtool.profile import load_profile, profile_path
from benchtool.protocol.dictionary.dictionary import Dictionary
from benchtool.protocol.dictionary.profiled import profiled_dictionary
from benchtool.shipped import shipped

TRANSDUCER: Final = "torque_transducer"
"""Channel of a torque transducer, which is not in the dictionary."""


class _Drive(Section):
    """Whether a document describes a drive."""

    model_config = ConfigDict(extra="ignore")

    drive: object = None


def sensed_units(dictionary: Dictionary) -> dict[str, str]:
    """Return the units of the signals of a drive, and of the torque transducer beside it, by channel."""
    return {each.name: each.unit for each in dictionary if each.role == "signal"} | {TRANSDUCER: "Nm"}


def sensed_units_of(name: str) -> dict[str, str]:
    """Return those of the drive of a profile, or of one with the shipped dictionary for a file that describes
    no drive.

    Raises:
        ProfileError, DictionaryError: the file, or the EDS that it names, cannot be read.
    """
    path = profile_path(name)
    if load_document(path, _Drive, ProfileError).drive is None:
        return sensed_units(Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1))
    profile = load_profile(name)
    return sensed_units(profiled_dictionary(profile, path, profile.drive.node_id))
