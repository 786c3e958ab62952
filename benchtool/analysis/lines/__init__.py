"""Lines at any frequency, of signals that need no period: their frequencies, amplitudes and courses."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
