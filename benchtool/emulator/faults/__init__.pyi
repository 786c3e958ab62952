from .catalogue import FAULTS as FAULTS
from .declaration import (
    Fault as Fault,
    Kind as Kind,
    Outcome as Outcome,
    Parameter as Parameter,
    Place as Place,
)
from .injection import (
    FaultInjector as FaultInjector,
)
from .spelling import (
    parse_fault as parse_fault,
)
