"""One stream of a bundle as a file for other tools: CSV, MATLAB, or MDF4 (ASAM)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import Final

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import csv

from benchtool.block import Block, number_array
from benchtool.errors import EnvironmentFailure, RecordingError
from benchtool.recording.files import replacing, require_free
from benchtool.recording.reader import Bundle

_TIME: Final = "time_s"


class Format(StrEnum):
    """Formats by the name that `--format` takes."""

    CSV = "csv"
    MAT = "mat"
    MDF4 = "mdf4"

    @property
    def suffix(self) -> str:
        """File name extension of the format."""
        return ".mf4" if self is Format.MDF4 else f".{self}"


def export(bundle: Bundle, stream: str, format_: Format, path: Path) -> Block:
    """Write a stream to `path`, which appears whole or not at all; the block that was written.

    Every format holds `tick`, `time_s`, since the first row or as a table of another tool had it, and the
    channels with their units and every bit
    of their values. Missing rows are left out: their ticks do not appear.

    Raises:
        RecordingError: `path` exists or cannot be written, or there is no such stream.
        EnvironmentFailure: the package for the format is not installed.
    """
    require_free(path)
    if not path.parent.is_dir():
        raise RecordingError(f"cannot write {path}: no folder {path.parent}; make it or choose another")
    block = bundle.block(stream)
    with replacing(path, format_.suffix) as part:
        _WRITERS[format_](part, stream, block, bundle)
    return block


def _time_s(block: Block) -> NDArray[np.float64]:
    """Return the time of the rows: as it was recorded, in a table of another tool, else by their ticks."""
    return np.ascontiguousarray(block.column(_TIME)) if _TIME in block.names else block.time_s()


def _others(block: Block) -> Iterator[tuple[str, str, NDArray[np.float64]]]:
    """Yield the channels but the time: name, unit and values."""
    for each in block.channels:
        if each.name != _TIME:
            yield each.name, each.unit, np.ascontiguousarray(block.column(each.name))


def _csv(path: Path, stream: str, block: Block, bundle: Bundle) -> None:
    """Write one header line, `name [unit]`, and numbers as the shortest decimals that read back to the same
    bits."""
    numbers = [("time_s", "s", _time_s(block)), *_others(block)]
    names = ["tick", *(f"{name} [{unit}]" if unit else name for name, unit, _ in numbers)]
    columns = [number_array(block.ticks()), *(number_array(values) for _, _, values in numbers)]
    with path.open("wb") as file:
        file.write((",".join(names) + "\n").encode())
        options = csv.WriteOptions(include_header=False)
        csv.write_csv(pa.Table.from_arrays(columns, names=names), file, options)


def _mat(path: Path, stream: str, block: Block, bundle: Bundle) -> None:
    """Write a struct named as the stream: fields of the channels, and `units` with the same names."""
    from scipy.io import savemat

    content = {"tick": block.ticks(), "time_s": _time_s(block)}
    content |= {name: values for name, _, values in _others(block)}
    units = {"tick": "", "time_s": "s"} | {name: unit for name, unit, _ in _others(block)}
    about = {"tick_s": block.tick_s, "stride": block.stride, "what": bundle.manifest.what}
    document = {_identifier(stream): {**content, "units": units, **about}}
    savemat(path, document, oned_as="column", long_field_names=True)


def _identifier(stream: str) -> str:
    """Return the stream's name as MATLAB can have it."""
    name = "".join(char if char.isalnum() else "_" for char in stream)
    return name if name[0].isalpha() else f"s_{name}"


def _mdf4(path: Path, stream: str, block: Block, bundle: Bundle) -> None:
    """Write one channel group with `time_s` as its master."""
    try:
        from asammdf import MDF, Signal
    except ImportError:
        raise EnvironmentFailure(
            "the package asammdf is not installed, which writes MDF4: pip install 'benchtool[mdf]'"
        ) from None
    time_s = _time_s(block)
    signals = [Signal(block.ticks(), time_s, name="tick")]
    signals += [Signal(values, time_s, name=name, unit=unit) for name, unit, values in _others(block)]
    with MDF(version="4.10") as file:
        file.start_time = datetime.fromisoformat(bundle.manifest.when)
        file.append(signals, acq_name=stream, comment=bundle.manifest.what)
        file.save(path, overwrite=True)


_WRITERS: dict[Format, Callable[[Path, str, Block, Bundle], None]] = {
    Format.CSV: _csv,
    Format.MAT: _mat,
    Format.MDF4: _mdf4,
}
