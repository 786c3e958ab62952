"""One defect of an emulated drive or its bench."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

from benchtool.profile import Profile

Make = Callable[[Any], Any]
"""Makes a replacement from what is replaced."""


@dataclass(frozen=True)
class Substitution:
    """A function or a value of the firmware that is replaced: attribute `name` of `owner`, a class or a
    module."""

    owner: Any
    name: str
    make: Make


def unchanged(_profile: Profile) -> Mapping[str, float]:
    """Return no alteration of the bench."""
    return {}


@dataclass(frozen=True)
class Mutant:
    """A defect by name, what it is in words, and how it is made.

    `alter` names keys of the emulated bench, for a profile, and `substitutions` replace parts of the firmware
    in this process.
    """

    name: str
    what: str
    alter: Callable[[Profile], Mapping[str, float]] = unchanged
    substitutions: tuple[Substitution, ...] = ()

    @contextmanager
    def applied(self) -> Iterator[None]:
        """Have the drives that are made within a `with` block in this process be this mutant."""
        with ExitStack() as stack:
            for each in self.substitutions:
                original = getattr(each.owner, each.name)
                stack.enter_context(patch.object(each.owner, each.name, each.make(original)))
            yield
