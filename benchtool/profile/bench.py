"""What stands beside the drive on a bench, as a profile states it."""

from __future__ import annotations

from benchtool.document import Section
from benchtool.profile.equipment import Load, Supply, Temperature, Transducer


class Bench(Section):
    """The bench of a profile; None where it leaves a table out, see `benchtool.profile.equipment`."""

    load: Load | None = None
    transducer: Transducer | None = None
    supply: Supply | None = None
    temperature: Temperature | None = None
