"""benchtool: a hardware-in-the-loop bench for motor drives.

    import benchtool

    with benchtool.open_bench("zhu2011", link="emulated") as bench:
        bench.drive["u_s"] = 81.65
        bench.load.torque(0.65)
        with bench.drive.enabled("velocity") as drive:
            drive.omega_m_command = 15.71
            bench.wait(1.5)
            block = drive.capture(0.52, ["i_a", "i_b", "i_c", "torque", "psi_s", "theta_m"])
    print(benchtool.analyze(block, bench.profile)["torque_ripple_pp"])

These names are what the API promises; other modules of the package may change at any time. Each is imported
when it is first used (PEP 562).
"""

from typing import Any

import lazy_loader

__version__ = "0.1.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Return a name of the API, imported now."""
    if name not in __all__:
        raise AttributeError(f"module 'benchtool' has no attribute '{name}': it has {', '.join(__all__)}")
    return _load(name)
