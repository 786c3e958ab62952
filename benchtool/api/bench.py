"""A bench: a drive at the other end of a link, and the equipment around it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Self

from benchtool.api.connection import Connection
from benchtool.api.drive import Drive
from benchtool.api.load import Ask, Load
from benchtool.api.waiting import wait

if TYPE_CHECKING:
    from benchtool.api.bundles import Bundle
    from benchtool.api.plans import PlanResult
    from benchtool.bench import Session, Supply, Thermometer
    from benchtool.plan import Plan
    from benchtool.profile import Profile


def open_bench(
    profile: str | Path,
    link: str = "emulated",
    *,
    seed: int = 0,
    real_time: bool = False,
    emulator: Mapping[str, float] = MappingProxyType({}),
    ask: Ask | None = None,
    progress: Callable[[str], None] | None = None,
) -> Bench:
    """Open a bench and check that its drive is the one of the profile; nothing is written or enabled.

        with benchtool.open_bench("zhu2011") as bench:
            print(bench.drive["u_s"])

    Args:
        profile: name of a shipped profile, or a TOML file.
        link: address of the drive, as `--link` takes it: `emulated`, `can:INTERFACE:CHANNEL?bitrate=...`,
            `serial:PORT?baudrate=...`.
        seed: of the emulated bench's noise.
        real_time: pace an emulated bench by the wall clock; else its time passes as fast as it is computed,
            and always only while a caller waits for it.
        emulator: what differs on an emulated bench, such as {"inverter.u_dc_V": 250.0}.
        ask: asks the person at a bench without load machine, such as `input`.
        progress: takes a line where something takes its time; they go to standard error without it.

    Raises:
        ProfileError, UsageError: what was asked for cannot be.
        LinkError: the adapter or the port cannot be opened, or no drive answers.
        IdentityMismatch, DictionaryMismatch: another drive answers.
    """
    from benchtool.bench import open_session

    with ExitStack() as stack:
        session = stack.enter_context(
            open_session(
                str(profile), link, seed=seed, real_time=real_time, note=progress or _tell, alter=emulator
            )
        )
        session.drive.check()
        return Bench(Connection(stack.pop_all(), session, link), seed, ask)


class Bench:
    """An open bench, as `open_bench` gives it.

    Within a `with` block, or until `close`; one that is forgotten is closed, with its drive disabled, when
    nothing refers to it any more or the interpreter ends.
    """

    def __init__(self, connection: Connection, seed: int = 0, ask: Ask | None = None) -> None:
        self._connection = connection
        self._seed = seed
        with connection.use() as session:
            self._profile = session.profile
        self._ask = ask

    @property
    def drive(self) -> Drive:
        """The drive: parameters, quantities, captures; enabled by `drive.enabled(mode)`."""
        with self._connection.use():
            return Drive(self._connection)

    @property
    def load(self) -> Load:
        """The load machine, or the person who does without."""
        with self._connection.use():
            return Load(self._connection, self._ask)

    @property
    def supply(self) -> Supply | None:
        """What supplies or measures the dc link; None of a bench without."""
        with self._connection.use() as session:
            return session.supply

    @property
    def thermometer(self) -> Thermometer | None:
        """What measures temperatures; None of a bench without."""
        with self._connection.use() as session:
            return session.thermometer

    @property
    def profile(self) -> Profile:
        """Everything that is known of the motor, the drive and the bench; also of a bench that is closed."""
        return self._profile

    @property
    def link(self) -> str:
        """Address of the drive."""
        return self._connection.link

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._connection.closed

    @property
    def time_s(self) -> float:
        """Seconds of the bench's clock, from an arbitrary origin; virtual ones on an emulated bench."""
        with self._connection.use() as session:
            return session.clock.now_s()

    def wait(self, duration_s: float) -> None:
        """Let time pass, in the clock of the bench; faults of the drive and of a running stream end it.

        Raises:
            ValueRefused: no duration.
            DriveFault: the drive reports a fault.
            LinkError: a running stream has stopped.
        """
        wait(self._connection, duration_s)

    def run(
        self,
        plan: str | Path | Plan,
        out: str | Path | None = None,
        *,
        allow_different: bool = False,
        note: str = "",
    ) -> PlanResult:
        """Run a plan on this bench as it stands; what the plan sets up is put back afterwards.

        Args:
            plan: name of a shipped plan, a TOML file, or a `Plan`.
            out: folder of the run bundle; one of its own in `runs` without it.
            allow_different: run a drive whose parameters contradict the profile, as those that were set here.
            note: a line for the manifest.

        Raises:
            PlanError: the plan is wrong, or does not fit this bench.
            BenchError: whatever went wrong; the drive is disabled.
        """
        from benchtool.api.plans import run_on

        return run_on(
            self._connection,
            plan,
            out,
            seed=self._seed,
            ask=self._ask,
            allow_different=allow_different,
            note=note,
        )

    def record(
        self,
        duration_s: float,
        channels: Iterable[str] = (),
        out: str | Path | None = None,
        *,
        rate_Hz: float = 100.0,
        note: str = "",
    ) -> Bundle:
        """Record the stream of the drive to disk, whatever it is doing, as `benchtool record` does.

        Every fifth of a second is on disk at once: what came until a crash can be read.

        Args:
            duration_s: seconds of drive time.
            channels: names of signals, those of a recording without any.
            out: folder of the bundle; one of its own in `runs` without it.
            rate_Hz: records per second.
            note: a line for the manifest.

        Raises:
            ValueRefused, CapabilityMissing: the drive cannot stream this.
            LinkClosed: the link was lost; the bundle holds what came until then.
            RecordingError: a file cannot be written.
        """
        from benchtool.api.recorder import record

        return record(
            self._connection, duration_s, tuple(channels), out, rate_Hz=rate_Hz, note=note, seed=self._seed
        )

    def close(self) -> None:
        """Disable the drive, take the load off, and close what was opened; again, it does nothing.

        Raises:
            StateError, LinkError: the drive does not confirm that it is disabled.
        """
        self._connection.close()

    def __enter__(self) -> Self:
        with self._connection.use():
            return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._connection.close(error)

    def __repr__(self) -> str:
        if self.closed:
            return f"<Bench on {self.link}: closed>"
        return f"<Bench on {self.link}: {self.profile.title}, {self.drive.state.value}>"

    def _repr_html_(self) -> str:
        return self.drive._repr_html_()


def session_of(bench: Bench) -> AbstractContextManager[Session]:
    """Return the session beneath a bench, for one caller alone and the length of a `with` block.

    For packages above this one; scripts have `Bench` and `Drive`.

    Raises:
        UsageError: in the `with` statement: the bench is closed, or of another process.
    """
    return bench._connection.use()


def _tell(text: str) -> None:
    sys.stderr.write(f"benchtool: {text}\n")
