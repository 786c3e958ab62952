"""The Block: uniformly clocked samples of several channels, the only thing that flows from wire to report."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
