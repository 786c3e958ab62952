"""Profiles: a motor, its drive and the bench they stand on, as one validated TOML file.

A number's key ends in its unit. `[drive.parameters]` uses the dictionary's names with the unit appended
(`u_s_V`, `omega_observer_rad_s`). Motor quantities are amplitude-invariant (peak) and per phase.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
