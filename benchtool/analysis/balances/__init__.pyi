from .deviations import (
    Deviation as Deviation,
    contradictions as contradictions,
    deviations as deviations,
    shared_cause as shared_cause,
    undefined as undefined,
)
from .flux_balance import (
    UNEXPLAINED as UNEXPLAINED,
    FluxBalance as FluxBalance,
    flux_balance as flux_balance,
)
from .flux_measurements import (
    FLUX_BALANCE as FLUX_BALANCE,
    FluxBalanceSettings as FluxBalanceSettings,
)
from .flux_model import Electrical as Electrical
from .motion_balance import (
    MOTION_BALANCE as MOTION_BALANCE,
    MotionBalance as MotionBalance,
    MotionBalanceSettings as MotionBalanceSettings,
    motion_balance as motion_balance,
)
from .simulation import (
    simulated_currents as simulated_currents,
    simulated_speed as simulated_speed,
)
from .unknowns import Solution as Solution
