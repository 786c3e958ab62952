from . import model as model
from .analyses import Analyses as Analyses
from .cases import (
    Case as Case,
    Coordinates as Coordinates,
    case_named as case_named,
    cases as cases,
    drive_time_s as drive_time_s,
)
from .changes import (
    Changes as Changes,
    places_of as places_of,
)
from .former_names import present_name as present_name
from .judged import (
    JudgedLimit as JudgedLimit,
    Missed as Missed,
)
from .lazy_catalogue import catalogue as catalogue
from .limits import (
    Limit as Limit,
    Verdict as Verdict,
    Waived as Waived,
    worst as worst,
)
from .model import (
    OperatingPoint as OperatingPoint,
    Plan as Plan,
    Record as Record,
    Setting as Setting,
    load_plan as load_plan,
    plan_names as plan_names,
    plan_path as plan_path,
    profiles_of as profiles_of,
    recorded_plan as recorded_plan,
    shipped_plans as shipped_plans,
)
from .not_made import not_made as not_made
from .operating_point import (
    NAMES as NAMES,
    CaseReadings as CaseReadings,
    default_limits as default_limits,
    measure_held as measure_held,
    measure_reached as measure_reached,
    read as read,
    signals_to_read as signals_to_read,
    targets as targets,
)
from .rated import (
    for_motor as for_motor,
    require_in_si as require_in_si,
)
from .rating import require_rated as require_rated
from .sensor_ranges import require_protected as require_protected
from .source import Source as Source
from .template import plan_text as plan_text
from .validation import (
    expected_period_s as expected_period_s,
    faults_of as faults_of,
    require_known as require_known,
)
