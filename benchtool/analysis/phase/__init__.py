"""The phase of a fundamental: followed where the speed wanders, held against an angle, told to both ends."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
