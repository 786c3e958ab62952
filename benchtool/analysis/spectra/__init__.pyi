from .current import (
    CurrentSpectrum as CurrentSpectrum,
    current_spectrum as current_spectrum,
)
from .lines import spectral_lines as spectral_lines
from .period_marks import (
    marks_of_rotor as marks_of_rotor,
    marks_of_tone as marks_of_tone,
)
from .unbalance import (
    CURRENT_UNBALANCE as CURRENT_UNBALANCE,
    current_unbalance as current_unbalance,
)
