from .capture_data import (
    MOST_VALUES as MOST_VALUES,
    CaptureHeader as CaptureHeader,
    decode_capture as decode_capture,
    encode_capture as encode_capture,
)
from .cia402 import (
    Command as Command,
    State as State,
    next_command as next_command,
    state_of as state_of,
    statusword as statusword,
    transition as transition,
)
from .dbc import (
    DbcMessage as DbcMessage,
    SignalRange as SignalRange,
)
from .modes import (
    CYCLIC_POSITION as CYCLIC_POSITION,
    PROFILE_POSITION as PROFILE_POSITION,
    Mode as Mode,
    first_supported as first_supported,
)
from .slcan import (
    BITRATES_BIT_S as BITRATES_BIT_S,
    OK as OK,
    REFUSED as REFUSED,
    AdapterLines as AdapterLines,
    Answer as Answer,
    Cause as Cause,
    Lines as Lines,
    SlcanCommand as SlcanCommand,
    SlcanFrame as SlcanFrame,
    TIME_MODULUS_ms as TIME_MODULUS_ms,
    format_frame as format_frame,
    parse_command as parse_command,
)
from .telemetry import (
    COUNTING_SIGNALS as COUNTING_SIGNALS,
    RecordDecoder as RecordDecoder,
    StreamCounters as StreamCounters,
    most_channels as most_channels,
    stream_channel as stream_channel,
    stream_layout as stream_layout,
)
