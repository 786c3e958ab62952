from .content import Report as Report
from .figures.twin import draw_twin as draw_twin
from .reproduction_page import (
    PAGE_MARK as PAGE_MARK,
    PlanFigures as PlanFigures,
    reproduction_page as reproduction_page,
)
from .writing import write_report as write_report
