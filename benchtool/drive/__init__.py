"""The drive as the host sees it: names and SI values, states, capture, supervision."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
