from .content import Report as Report
from .figures.twin import draw_twin as draw_twin
from .junit import (
    junit as junit,
    write_junit as write_junit,
)
from .reproduction_page import (
    PAGE_MARK as PAGE_MARK,
    PlanFigures as PlanFigures,
    reproduction_page as reproduction_page,
)
from .writing import write_report as write_report
