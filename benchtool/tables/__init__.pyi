from .answer import (
    TableAnswer as TableAnswer,
    analyze_table as analyze_table,
    table_block as table_block,
)
from .columns import (
    PHASES as PHASES,
    TableQuestion as TableQuestion,
)
from .kept import KeptTable as KeptTable
from .record import Record as Record
from .scaling import quantity as quantity
from .text import TextTable as TextTable
from .units import (
    KNOWN as KNOWN,
    unit_factor as unit_factor,
    units_of as units_of,
)
