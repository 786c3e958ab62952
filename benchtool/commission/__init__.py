"""Commissioning: a motor identified step by step, from its nameplate to what the drive is to hold."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
