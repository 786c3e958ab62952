"""Balances of stator flux and torque, by which parameters are found and believed ones tested."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
