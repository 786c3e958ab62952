from . import recording as recording
from .case import (
    Progress as Progress,
    capture as capture,
    capture_stimulus as capture_stimulus,
)
from .checks import check_plan as check_plan
from .equipment import readings as readings
from .folder import bundle_folder as bundle_folder
from .jog import (
    jog as jog,
    require_mode as require_mode,
    within_rating as within_rating,
)
from .parallel import run_in_processes as run_in_processes
from .parameter_check import check_parameters as check_parameters
from .recording import (
    Ended as Ended,
    Recording as Recording,
    Status as Status,
    manifest_of as manifest_of,
    prepared as prepared,
    record as record,
)
from .runner import (
    RunInfo as RunInfo,
    run_plan as run_plan,
)
