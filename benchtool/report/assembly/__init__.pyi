from .commissioning import (
    CAPTURES as CAPTURES,
    LOOPS as LOOPS,
    commissioning_report as commissioning_report,
)
from .comparison import comparison_report as comparison_report
from .figures import write_pictures as write_pictures
from .plan import case_label as case_label
from .run import run_report as run_report
from .session import session_report as session_report
from .table import (
    keep as keep,
    table_report as table_report,
)
