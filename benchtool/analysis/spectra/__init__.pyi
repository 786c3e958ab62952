from .current import (
    CurrentSpectrum as CurrentSpectrum,
    current_spectrum as current_spectrum,
)
from .lines import spectral_lines as spectral_lines
