from .content import Report as Report
from .figures.overview import draw_channels as draw_channels
from .figures.session import (
    draw_map as draw_map,
    draw_traces as draw_traces,
)
from .figures.twin import draw_twin as draw_twin
from .images import png as png
from .junit import (
    BrokenOff as BrokenOff,
    junit as junit,
    write_junit as write_junit,
)
from .reproduction_page import (
    PAGE_MARK as PAGE_MARK,
    PlanFigures as PlanFigures,
    reproduction_page as reproduction_page,
)
from .writing import (
    report_files as report_files,
    write_report as write_report,
)
