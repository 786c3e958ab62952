from .alignment import (
    Alignment as Alignment,
    Sampling as Sampling,
    align as align,
    frame_numbers as frame_numbers,
)
from .certificate import (
    Certificate as Certificate,
    StreamFacts as StreamFacts,
    certificate_units as certificate_units,
    certify as certify,
    certify_recording as certify_recording,
)
from .clock_fit import (
    ArrivalStatistics as ArrivalStatistics,
    ClockFit as ClockFit,
)
from .fanout import (
    FanOut as FanOut,
    Sink as Sink,
)
from .frames import FrameLog as FrameLog
from .journal import (
    Journal as Journal,
    keep_journal as keep_journal,
)
from .limit_supervision import LimitSupervision as LimitSupervision
from .recorder import (
    STREAM as STREAM,
    record_stream as record_stream,
)
from .setpoints import Setpoints as Setpoints
from .stream import (
    DEFAULT_CHANNELS as DEFAULT_CHANNELS,
    DEFAULT_RATE_HZ as DEFAULT_RATE_HZ,
    StreamReport as StreamReport,
    TelemetryStream as TelemetryStream,
)
