"""Have every reader of files read damaged, huge and malicious ones for a given time.

python -m tests.fuzz.documents --seconds 60 --seed 0 [--json]

A round takes a file that is in order (profile, plan, EDS, table, bundle), damages it, and has it read as the
command line reads it. A round fails if anything but an error of benchtool is raised: exit code 2 or 3, never
a traceback. The same seed makes the same rounds.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from benchtool.block import Block, Channel
from benchtool.errors import EnvironmentFailure, UsageError
from benchtool.plan.model import load_plan, plan_path
from benchtool.profile import load_profile, profile_path
from benchtool.protocol.dictionary import Dictionary
from benchtool.recording import Bundle, BundleWriter, Manifest
from benchtool.recording.integrity import verify
from benchtool.recording.seal import hash_of, read_sealed_json, write_json
from benchtool.shipped import shipped
from benchtool.tables import TableQuestion, analyze_table

_WORDS = (
    *(b"\x00", b"\xff\xfe", b"[", b"]", b"[[", b'"', b"'''", b"=", b"\n", b"nan", b"inf", b"-1", b"1e999"),
    *(
        b"99999999999999999999999999",
        b"0x",
        b"../../../../etc/passwd",
        b"/dev/zero",
        b"\\\\?\\C:\\",
        b"{",
        b"}",
    ),
    *(b"true", b"null", "\u202e".encode(), b"%s%n", b"0x1F800000", b"$NODEID+", b"ParameterName=", b","),
)
_HUGE = 200_000


def damaged(content: bytes, draw: random.Random) -> bytes:
    """Return a file's content with one to four kinds of damage."""
    data = bytearray(content)
    for _ in range(draw.randint(1, 4)):
        at = draw.randrange(len(data) + 1)
        match draw.randrange(9):
            case 0:
                del data[at:]
            case 1:
                del data[at : at + draw.randint(1, 40)]
            case 2 if data:
                data[at % len(data)] ^= 1 << draw.randrange(8)
            case 3:
                data[at:at] = draw.choice(_WORDS)
            case 4:
                data[at:at] = draw.randbytes(draw.randint(1, 16))
            case 5:
                data[at:at] = bytes(data[max(0, at - 60) : at]) * draw.randint(1, 3)
            case 6:
                data[at:at] = draw.choice((b"[", b"{", b"a.", b"9", b",", b"(")) * draw.choice((50, 2000))
            case 7:
                lines = bytes(data).split(b"\n")
                draw.shuffle(lines)
                data[:] = b"\n".join(lines)
            case _:
                data[at:at] = draw.choice((b"x", b" ", b"1", b"\n")) * draw.choice((1000, _HUGE))
    return bytes(data)


class Reader:
    """Files in order, and what reads them; `folder` is for those of the rounds."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._bundle = folder / "bundle"
        _write_bundle(self._bundle)
        profile = profile_path("zhu2011").read_bytes()
        plan = plan_path("zhu2011/laws").read_bytes()
        eds = (shipped("firmware_protocol") / "drive.eds").read_bytes()
        table = b"t [ms],i_a [A],angle [deg]\n" + b"".join(
            f"{n * 0.1:.1f},{np.sin(n / 9.0):.4f},{n * 6 % 360}\n".encode() for n in range(300)
        )
        self.kinds: dict[str, Callable[[random.Random], None]] = {
            "profile": lambda draw: self._text(profile, "toml", lambda path: load_profile(str(path)), draw),
            "plan": lambda draw: self._text(plan, "toml", lambda path: load_plan(str(path)), draw),
            "eds": lambda draw: self._text(eds, "eds", lambda path: Dictionary.from_eds(path, 1), draw),
            "table": lambda draw: self._text(table, "csv", _read_table, draw),
            "bundle": self._damage_bundle,
        }

    def _text(self, content: bytes, suffix: str, read: Callable[[Path], object], draw: random.Random) -> None:
        path = self._folder / f"file.{suffix}"
        path.write_bytes(damaged(content, draw))
        read(path)

    def _damage_bundle(self, draw: random.Random) -> None:
        place = self._folder / "damaged"
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(self._bundle, place)
        files = sorted(path for path in place.rglob("*") if path.is_file())
        path = draw.choice(files)
        match draw.randrange(6):
            case 0:
                path.unlink()
            case 1:
                _rename_stream(place, draw)
            case 2:
                _from_elsewhere(place, draw)
            case _:
                path.write_bytes(damaged(path.read_bytes(), draw))
                if path.name != "manifest.json" and draw.random() < 0.5:
                    _vouch_for(place, path)
        _read_bundle(place)


def _write_bundle(folder: Path) -> None:
    manifest = Manifest(what="fuzz", when="2026-01-01T00:00:00Z", complete=True)
    data = np.linspace(0.0, 1.0, 200).reshape(100, 2)
    with BundleWriter(folder, manifest) as writer:
        writer.append("capture", Block((Channel("i_a", "A"), Channel("i_b", "A")), 0, 1, 1e-4, data))
        writer.finish({"torque_mean": {"value": 1.0, "unit": "Nm"}})


def _vouch_for(place: Path, path: Path) -> None:
    """Have the manifest state the hash that a damaged file has, as one who forges a bundle would."""
    manifest, name = place / "manifest.json", path.relative_to(place).as_posix()
    document, _ = read_sealed_json(manifest)
    if name in document["files"]:
        document["files"][name] = hash_of(path).model_dump(mode="json")
    write_json(manifest, document, sealed=True)


def _rename_stream(place: Path, draw: random.Random) -> None:
    """Name a stream or a file of the manifest like a place outside of the bundle."""
    path = place / "manifest.json"
    document, _ = read_sealed_json(path)
    name = draw.choice(("../../outside", "/etc/passwd", "a/b", "", ".", "capture\x00", "x" * 5000))
    table = draw.choice(("streams", "files"))
    entries = document.get(table) or {}
    if entries:
        entries[name] = entries.pop(draw.choice(sorted(entries)))
    write_json(path, document, sealed=True)


def _from_elsewhere(place: Path, draw: random.Random) -> None:
    """Have the manifest state another version, or values of other types."""
    path = place / "manifest.json"
    document, _ = read_sealed_json(path)
    key = draw.choice(("schema_version", *document))
    document[key] = draw.choice((99, -1, "3", None, [], {}, 1e300, True, {"a": {"b": []}}))
    write_json(path, document, sealed=True)


def _read_bundle(place: Path) -> None:
    bundle = Bundle.open(place)
    verify(place)
    assert bundle.certificate is None or isinstance(bundle.certificate, dict)
    assert bundle.events is not None
    for stream in bundle.streams:
        bundle.block(stream)


def _read_table(path: Path) -> None:
    analyze_table(TableQuestion(file=path, time="1", columns={"current": "2", "angle": "3"}, pole_pairs=4))


def rounds(folder: Path, draw: random.Random, counts: Counter[str]) -> Iterator[None]:
    """Yield after each round, with its outcome counted.

    Raises:
        AssertionError: a reader raised something else than a usage or an environment error.
    """
    reader = Reader(folder)
    while True:
        for name, read in reader.kinds.items():
            told = ""
            try:
                read(draw)
                counts[f"{name} read"] += 1
            except (UsageError, EnvironmentFailure) as refused:
                counts[f"{name} refused"] += 1
                told = str(refused)
            except Exception as failure:
                raise AssertionError(f"{name}: {failure!r}") from failure
            if "\n" in told:
                raise AssertionError(f"{name}: more than a line: {told}")
            yield


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder for the length of a `with` block."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


def main() -> int:
    """Run rounds for the time that is given."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.documents", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    counts: Counter[str] = Counter()
    end_s = time.monotonic() + given.seconds
    with scratch() as folder:
        for _ in rounds(folder, random.Random(given.seed), counts):
            if time.monotonic() > end_s:
                break
    text = json.dumps(dict(sorted(counts.items()))) if given.json else str(dict(sorted(counts.items())))
    sys.stdout.write(f"{text}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
