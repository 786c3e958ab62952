from .capabilities import (
    Capabilities as Capabilities,
    Capability as Capability,
    cost as cost,
)
from .capture import (
    Capture as Capture,
    CaptureRequest as CaptureRequest,
)
from .identity import Identity as Identity
from .index_search import find_index as find_index
from .player import play as play
from .quantities import (
    SPEED as SPEED,
    SPEED_SETPOINT as SPEED_SETPOINT,
    TORQUE as TORQUE,
    TORQUE_SETPOINT as TORQUE_SETPOINT,
    Quantity as Quantity,
    in_si as in_si,
    is_own as is_own,
)
from .remote import RemoteDrive as RemoteDrive
from .stimulus import Stimulus as Stimulus
