"""Byte ports that other programs open: pseudo-terminals and TCP."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
