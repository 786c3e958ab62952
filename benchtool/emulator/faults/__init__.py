"""Faults of the emulated bench: a declared table, and what begins and ends each of them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
