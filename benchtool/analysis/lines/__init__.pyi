from .lines import spectral_lines as spectral_lines
