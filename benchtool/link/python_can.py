"""Import python-can without what it only needs for MDF4 log files."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Final

_READER: Final = "can.io.mf4"
_OPTIONAL: Final = "asammdf"


class _WithoutMdf(MetaPathFinder):
    """Says that asammdf is not installed, as long as it is python-can's reader of MDF4 that asks for it."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname == _OPTIONAL and _is_being_imported(_READER):
            raise ModuleNotFoundError(f"no {_OPTIONAL} for {_READER}", name=_OPTIONAL)
        return None


def import_can_without_mdf() -> None:
    """Spare this process the import of asammdf with pandas, which costs more than all else of python-can.

    It is installed by the extra `mdf`, and exports import it as before; `can.MF4Reader` and `can.MF4Writer`
    then do not work in this process. So it is for processes that nothing but this package runs in.
    """
    if not any(isinstance(finder, _WithoutMdf) for finder in sys.meta_path):
        sys.meta_path.insert(0, _WithoutMdf())


def _is_being_imported(name: str) -> bool:
    module = sys.modules.get(name)
    return bool(getattr(getattr(module, "__spec__", None), "_initializing", False))
