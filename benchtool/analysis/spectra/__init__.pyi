from .current import (
    CurrentSpectrum as CurrentSpectrum,
    current_spectrum as current_spectrum,
)
from .unbalance import (
    CURRENT_UNBALANCE as CURRENT_UNBALANCE,
    current_unbalance as current_unbalance,
)
