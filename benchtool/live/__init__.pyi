from .bundle import (
    setup_of as setup_of,
    show_bundle as show_bundle,
)
from .names import (
    CAPTURE as CAPTURE,
    STREAM as STREAM,
    TRANSDUCER as TRANSDUCER,
)
from .panels.documents import (
    ShownStep as ShownStep,
    certificate_document as certificate_document,
    results_document as results_document,
    steps_document as steps_document,
)
from .sinks.file import FileDestination as FileDestination
from .sinks.sink import (
    Destination as Destination,
    RecordingSink as RecordingSink,
)
from .sinks.viewer import (
    LOOPBACK as LOOPBACK,
    Viewer as Viewer,
)
from .view import (
    LiveView as LiveView,
    Setup as Setup,
)
