from .bench import (
    DriveStatus as DriveStatus,
    EmulatedBench as EmulatedBench,
    is_compiled as is_compiled,
)
from .machine.open_loop import (
    OpenLoop as OpenLoop,
    open_loop as open_loop,
)
from .thermometer import EmulatedThermometer as EmulatedThermometer
