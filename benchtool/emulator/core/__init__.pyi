from .core import (
    Core as Core,
    Trip as Trip,
)
