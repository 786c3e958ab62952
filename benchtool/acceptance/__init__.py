"""Acceptance of drives: a pytest plugin, a suite of tests that ships, and mutants that try the suite.

Nothing here imports pytest until it is used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
