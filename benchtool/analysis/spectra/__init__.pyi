from .angle_following import marks_of_rotor as marks_of_rotor
from .current import (
    CurrentSpectrum as CurrentSpectrum,
    current_spectrum as current_spectrum,
)
from .lines import spectral_lines as spectral_lines
from .unbalance import (
    CURRENT_UNBALANCE as CURRENT_UNBALANCE,
    current_unbalance as current_unbalance,
)
