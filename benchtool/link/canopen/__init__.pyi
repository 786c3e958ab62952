from .bus import open_bus as open_bus
from .discovery import scan_bus as scan_bus
from .link import CanopenLink as CanopenLink
from .reception import (
    receive_frames as receive_frames,
    stop_receiving as stop_receiving,
)
from .timestamps import (
    AdapterTimestamps as AdapterTimestamps,
    timestamp as timestamp,
)
from .virtual import (
    FrameBurst as FrameBurst,
    Received as Received,
    VirtualTimeBus as VirtualTimeBus,
)
