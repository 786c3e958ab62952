from . import (
    cob_id as cob_id,
    sdo as sdo,
)
from .abort import (
    Abort as Abort,
    abort_text as abort_text,
)
from .cob_id import (
    CAN_ID as CAN_ID,
    HOST_NODE as HOST_NODE,
    INVALID as INVALID,
    TPDO as TPDO,
)
from .emcy import (
    Emergency as Emergency,
    ErrorCode as ErrorCode,
    error_register as error_register,
    error_text as error_text,
)
from .nmt import (
    NmtCommand as NmtCommand,
    NmtState as NmtState,
    heartbeat_state as heartbeat_state,
)
from .pdo import (
    MAX_BITS as MAX_BITS,
    MAX_ENTRIES as MAX_ENTRIES,
    PDO_PARAMETERS as PDO_PARAMETERS,
    TPDO_COMMUNICATION as TPDO_COMMUNICATION,
    Pdo as Pdo,
    event_timer_ticks as event_timer_ticks,
    most_tpdos as most_tpdos,
    rpdo as rpdo,
    tpdo as tpdo,
)
from .sdo import (
    EXPEDITED as EXPEDITED,
    LAST_SEGMENT as LAST_SEGMENT,
    MAX_BLOCK_SIZE as MAX_BLOCK_SIZE,
    SEGMENT_SIZE as SEGMENT_SIZE,
    SIZE_INDICATED as SIZE_INDICATED,
    SPECIFIER as SPECIFIER,
    Block as Block,
    Request as Request,
    Response as Response,
)
