from .clock_anchor import (
    ClockAnchor as ClockAnchor,
    TickAnchor as TickAnchor,
)
from .discovery import (
    Found as Found,
    duplicates as duplicates,
)
from .interface import (
    BatchLink as BatchLink,
    CountsAnswers as CountsAnswers,
    CountsMalformed as CountsMalformed,
    Frame as Frame,
    FrameLink as FrameLink,
    FrameReceiver as FrameReceiver,
    Link as Link,
    LinkCounters as LinkCounters,
    ReceivedEmergency as ReceivedEmergency,
)
from .pipe import (
    PipePort as PipePort,
    pipe as pipe,
)
from .port import (
    DEFAULT_BAUDRATE as DEFAULT_BAUDRATE,
    READ_S as READ_S,
    Port as Port,
    open_port as open_port,
)
from .process_data import (
    DriveAccess as DriveAccess,
    Sent as Sent,
)
from .python_can import import_can_without_mdf as import_can_without_mdf
from .replay import (
    FRAMES as FRAMES,
    ReplayLink as ReplayLink,
)
from .supervision import StreamSupervisor as StreamSupervisor
