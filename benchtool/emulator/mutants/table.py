"""The mutants, all of them."""

from __future__ import annotations

from typing import Final

from benchtool.emulator.mutants.bench import BENCH
from benchtool.emulator.mutants.commands import COMMANDS
from benchtool.emulator.mutants.control import CONTROL
from benchtool.emulator.mutants.mutant import Mutant
from benchtool.emulator.mutants.supervision import SUPERVISION

MUTANTS: Final[tuple[Mutant, ...]] = (*BENCH, *SUPERVISION, *COMMANDS, *CONTROL)
"""Drives and benches with one defect each."""
