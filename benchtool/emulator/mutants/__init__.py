"""Mutants: emulated drives and benches with one defect each, on which tests are tried.

Nothing else imports this package: a drive is changed only within `Mutant.applied`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
