from .campaign import (
    Campaign as Campaign,
    Trial as Trial,
    conduct_campaign as conduct_campaign,
    run_trial as run_trial,
)
from .measuring import Measure as Measure
from .notes import Attach as Attach
from .session import run_suite as run_suite
