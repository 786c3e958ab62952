from .bench import (
    Bench as Bench,
    open_bench as open_bench,
    session_of as session_of,
)
from .bundles import (
    open_bundle as open_bundle,
    write_report as write_report,
)
from .comparison import compare as compare
from .drive import Drive as Drive
from .live import show_live as show_live
from .plans import (
    Plan as Plan,
    PlanResult as PlanResult,
    run_plan as run_plan,
)
from .results import analyze as analyze
