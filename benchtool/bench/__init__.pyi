from .equipment import (
    LoadMachine as LoadMachine,
    Supply as Supply,
    Thermometer as Thermometer,
)
from .faults import (
    FaultEntry as FaultEntry,
    Faults as Faults,
    fault_table as fault_table,
    require_faults as require_faults,
)
from .operator import (
    UNLOAD as UNLOAD,
    Confirmation as Confirmation,
    Done as Done,
    Prompt as Prompt,
    ask as ask,
    confirmed_beforehand as confirmed_beforehand,
    instruction as instruction,
    no_operator as no_operator,
)
from .serving import (
    Endpoint as Endpoint,
    ServedDrive as ServedDrive,
    serve as serve,
)
from .session import (
    Session as Session,
    dictionary_of as dictionary_of,
    emulator_is_compiled as emulator_is_compiled,
    equipment_of as equipment_of,
    open_session as open_session,
)
