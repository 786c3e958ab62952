from .analysis import (
    Measurement as Measurement,
)
from .api import (
    Bench as Bench,
    Drive as Drive,
    Plan as Plan,
    analyze as analyze,
    compare as compare,
    open_bench as open_bench,
    open_bundle as open_bundle,
    run_plan as run_plan,
    show_live as show_live,
    write_report as write_report,
)
from .block import (
    Block as Block,
)
from .drive import (
    Stimulus as Stimulus,
)
from .errors import (
    BenchError as BenchError,
)

__all__: list[str]
__version__: str
