"""The drive of a bench: its parameters, its quantities while they happen, captures, streams."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchtool.api.connection import Connection
from benchtool.api.parameters import Given, Parameters, plain
from benchtool.api.recorded import RecordedBlock
from benchtool.api.values import Values
from benchtool.errors import NoSuchAttribute, UsageError, ValueRefused
from benchtool.notebook import table_html

if TYPE_CHECKING:
    from benchtool.api.enabled import EnabledDrive
    from benchtool.api.stream import Stream
    from benchtool.bench import Session
    from benchtool.drive import Capabilities, Identity, Stimulus
    from benchtool.protocol import Mode, State

_SMALLEST_S = 1e-6


class Drive:
    """A drive, known to speak the dictionary of its profile; whether it is enabled is its `state`.

        drive["u_s"] = 81.65                  # a parameter, in SI, read back after it was written
        drive["R_s"] = "123 mohm"             # or with a unit
        drive.values["torque"]                # what it measures now
        with drive.enabled("velocity") as running:
            running.omega_m_command = "150 rpm"

    `Bench.drive` gives it.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    # ---- what it is ----------------------------------------------------------------------------------------

    @property
    def identity(self) -> Identity:
        """Who answers: vendor, product, firmware, hash of its dictionary."""
        with self._use() as session:
            return session.drive.identify()

    @property
    def capabilities(self) -> Capabilities:
        """What it can do, by its dictionary."""
        with self._use() as session:
            return session.drive.capabilities

    @property
    def state(self) -> State:
        """State of the CiA 402 state machine, as it is read now."""
        with self._use() as session:
            return session.drive.state()

    # ---- parameters and quantities -------------------------------------------------------------------------

    @property
    def parameters(self) -> Parameters:
        """Its parameters, with units, limits and defaults."""
        with self._use():
            return Parameters(self._connection)

    @property
    def values(self) -> Values:
        """What it measures and estimates, each read when asked for."""
        with self._use():
            return Values(self._connection)

    def __getitem__(self, name: str) -> Given:
        """Return the value of any readable object: a parameter, a signal, a setpoint.

        Raises:
            ValueRefused: no such object, or one that cannot be read; the message names the nearest.
            NoAnswer, SdoAbort: the drive did not answer, or refused.
        """
        from benchtool.drive.parameters import readable

        with self._use() as session:
            return plain(session.drive.read(readable(session.drive.dictionary, name)))

    def __setitem__(self, name: str, value: Given) -> None:
        """Write a parameter and read it back; as `parameters[name] = value`."""
        with self._use() as session:
            variable = session.drive.dictionary.get(name)
            if variable is not None and variable.role == "command":
                raise ValueRefused(
                    f"'{name}' is a setpoint of a drive that is enabled, nothing was sent: "
                    f"with drive.enabled(mode) as running: running.{name} = {value!r}"
                )
            self.parameters[name] = value

    def update(self, values: Mapping[str, Given]) -> None:
        """Write several parameters: all of them hold, or none; as `parameters.update(values)`."""
        self.parameters.update(values)

    def watch(self, *names: str, duration_s: float = math.inf, period_s: float = 0.2) -> None:
        """Show quantities on one line that renews itself, for a time or until Ctrl-C, which is no error here.

        Raises:
            ValueRefused: no such quantity.
            UsageError: there is no end, and the time of an emulated bench is not paced by the wall clock.
        """
        from benchtool.api.watching import watch

        with self._use() as session:
            if math.isinf(duration_s) and session.clock.virtual and not session.clock.paced:
                raise UsageError(
                    "the time of this emulated bench passes as fast as it is computed: give duration_s, or "
                    "open the bench with real_time=True"
                )
        watch(self._connection, names, duration_s, period_s)

    # ---- commanding ----------------------------------------------------------------------------------------

    def enabled(self, mode: str | Mode = "velocity") -> EnabledDrive:
        """Return the drive enabled in a mode for the length of a `with` block, and disabled on every way out.

        Args:
            mode: "velocity", "torque", "voltage" or "current".

        Raises:
            ValueRefused: no such mode; in the `with` statement also: the drive has it not.
            DriveFault, StateError, LinkError: in the `with` statement: it cannot be enabled.
        """
        from benchtool.api.enabled import EnabledDrive, mode_named

        with self._use():
            return EnabledDrive(self._connection, mode_named(mode))

    def enable(self, mode: str | Mode = "velocity") -> EnabledDrive:
        """Enable the drive until `disable`, for a shell; scripts use `with drive.enabled(mode)`.

        It is disabled at the latest when the bench is closed or the interpreter ends.
        """
        return self.enabled(mode).__enter__()

    def disable(self) -> None:
        """Disable the drive, even if another host enabled it.

        Raises:
            StateError, LinkClosed: it does not confirm that it is disabled.
        """
        with self._use() as session:
            if (running := self._connection.enabled) is not None:
                running.__exit__(None, None, None)
            else:
                session.drive.disable()

    def reset_fault(self) -> None:
        """Leave the fault state.

        Raises:
            StateError: the drive stays in fault.
        """
        with self._use() as session:
            session.drive.reset_fault()

    # ---- recording -----------------------------------------------------------------------------------------

    def capture(self, duration_s: float, channels: Iterable[str], *, stride: int = 1) -> RecordedBlock:
        """Capture signals on the drive at the control rate, from now on, and return them.

        Where the bench has a torque transducer it records meanwhile, see `RecordedBlock.transducer`.

        Args:
            duration_s: seconds of drive time.
            channels: names of signals, 16 at most.
            stride: control ticks for each row.

        Raises:
            ValueRefused: no such signal, or a duration that cannot be.
            CapabilityMissing: the drive has no capture.
            DriveFault, CaptureError, SdoAbort, LinkError: as they come.
        """
        from benchtool.api.recorded import recorded
        from benchtool.plan import Record
        from benchtool.run import capture

        with self._use() as session:
            names = _signals(session, channels)
            _require_rows(session, duration_s, stride)
            record = Record.model_construct(duration_s=duration_s, channels=names, stride=stride)
            block, transducer = capture(session, record, _clock_of(self._connection))
            return recorded(session, block, transducer)

    def play(
        self,
        stimulus: Stimulus,
        channels: Iterable[str],
        *,
        duration_s: float | None = None,
        pretrigger_s: float = 0.01,
    ) -> RecordedBlock:
        """Have the enabled drive play a test signal, paced by itself, and capture meanwhile.

        Args:
            stimulus: what to play; beyond the rating of the motor it is refused.
            channels: names of signals, 16 at most; `stimulus` is one.
            duration_s: of the capture; as long as the stimulus without it.
            pretrigger_s: how much of it lies before the stimulus begins.

        Raises:
            ValueRefused: beyond the rating, another mode, no such signal.
            StimulusError: it was stopped before its end.
            DriveFault, CaptureError, SdoAbort, LinkError: as they come.
        """
        from benchtool.api.recorded import recorded
        from benchtool.plan import Record
        from benchtool.run import capture_stimulus

        with self._use() as session:
            names = _signals(session, channels)
            period_s = session.drive.number("control_period")
            if duration_s is None:
                duration_s = pretrigger_s + stimulus.ticks(period_s) * stimulus.repetitions * period_s
            _require_rows(session, duration_s, 1)
            if not 0.0 <= pretrigger_s < duration_s:
                raise ValueRefused(
                    f"pretrigger_s is {pretrigger_s:g} s of {duration_s:g} s: from 0 to less than the whole "
                    f"is expected; nothing was sent"
                )
            record = Record.model_construct(
                duration_s=duration_s, channels=names, stride=1, pretrigger_s=pretrigger_s
            )
            return recorded(
                session, *capture_stimulus(session, record, stimulus, _clock_of(self._connection))
            )

    def stream(
        self, channels: Iterable[str] = (), *, rate_Hz: float = 100.0, live: str | Path = ""
    ) -> Stream:
        """Return what the drive streams for the length of a `with` block, gathered in memory.

        Args:
            channels: names of signals, those of a recording without any.
            rate_Hz: records per second.
            live: where it is shown meanwhile, as `show_live` takes it: "viewer", "web" or a .rrd file.
        """
        from benchtool.api.stream import Stream

        with self._use():
            return Stream(self._connection, tuple(channels), rate_Hz, live)

    def record(
        self, duration_s: float, channels: Iterable[str] = (), *, rate_Hz: float = 100.0
    ) -> RecordedBlock:
        """Record the stream for a time, whatever the drive is doing; `Bench.record` writes it to disk.

        Raises:
            ValueRefused: the drive cannot stream this.
            LinkError: the link was lost.
        """
        require_duration(duration_s)
        with self._use() as session, self.stream(channels, rate_Hz=rate_Hz) as stream:
            session.drive.wait(duration_s)
        return stream.block

    # ---- as Python sees it ---------------------------------------------------------------------------------

    @contextmanager
    def _use(self) -> Iterator[Session]:
        with self._connection.use() as session:
            yield session

    def __setattr__(self, name: str, value: Any) -> None:
        """Attributes are this object's own: a setpoint or a parameter set by mistake is refused.

        Raises:
            NoSuchAttribute: there is no such attribute to be set.
        """
        if name.startswith("_"):
            object.__setattr__(self, name, value)
        elif (running := self._running_with(name)) is not None:
            setattr(running, name, value)
        else:
            raise NoSuchAttribute(self._no_attribute(name))

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_") and (running := self._running_with(name)) is not None:
            return getattr(running, name)
        raise NoSuchAttribute(self._no_attribute(name))

    def __dir__(self) -> Iterable[str]:
        from benchtool.api.enabled import SETPOINTS

        return [*super().__dir__(), *(name for name in SETPOINTS if self._running_with(name) is not None)]

    def _running_with(self, name: str) -> EnabledDrive | None:
        """Of a setpoint, the same drive where it is enabled."""
        from benchtool.api.enabled import SETPOINTS

        running = self._connection.enabled
        return running if name in SETPOINTS and running is not self else None

    def _no_attribute(self, name: str) -> str:
        """Return what to say of an attribute that there is not."""
        from benchtool.api.enabled import SETPOINTS

        if name in SETPOINTS:
            return (
                f"'{name}' is a setpoint of a drive that is enabled: "
                f"with bench.drive.enabled(mode) as drive: drive.{name} = ..."
            )
        return f"a drive has no attribute '{name}'; parameters and signals are items: drive['{name}']"

    def _ipython_key_completions_(self) -> list[str]:
        with self._use() as session:
            return [each.name for each in session.drive.dictionary if each.readable]

    def __repr__(self) -> str:
        if self._connection.closed:
            return f"<{type(self).__name__}: closed>"
        with self._connection.use() as session:
            return f"<{type(self).__name__} on {self._connection.link}: {session.drive.state().value}>"

    def _repr_html_(self) -> str:
        with self._use() as session:
            facts = vars(session.drive.identify())
            rows = [("state", session.drive.state().value), ("link", self._connection.link)]
        rows += [
            (name, f"0x{value:X}" if isinstance(value, int) else str(value)) for name, value in facts.items()
        ]
        return table_html(("drive", ""), rows)


def _signals(session: Session, channels: Iterable[str]) -> tuple[str, ...]:
    """Return the names of what can be captured.

    Raises:
        ValueRefused: none, too many, one twice, or one that is no signal.
    """
    if isinstance(channels, str):
        raise ValueRefused(f"channels are {channels!r}, a list of names is expected: ['{channels}']")
    names = tuple(channels)
    for position, name in enumerate(names):
        variable = session.drive.dictionary[name]
        if variable.role != "signal":
            raise ValueRefused(
                f"'{name}' is a {variable.role} and cannot be captured; nothing was sent: choose a signal, "
                f"see drive.values"
            )
        if name in names[:position]:
            raise ValueRefused(f"channel '{name}' appears twice, once is expected; nothing was sent")
    return names


def _require_rows(session: Session, duration_s: float, stride: int) -> None:
    require_duration(duration_s)
    if isinstance(stride, bool) or not isinstance(stride, int) or stride < 1:
        raise ValueRefused(f"stride is {stride!r}, a whole number from 1 on is expected; nothing was sent")
    if (row_s := stride * session.drive.number("control_period")) > duration_s:
        raise ValueRefused(
            f"{duration_s:g} s hold no row, which takes {row_s:g} s: capture longer; nothing was sent"
        )


def require_duration(duration_s: float) -> None:
    """Refuse a duration that is not positive and finite.

    Raises:
        ValueRefused: no number, not above 0, or without an end.
    """
    if not (isinstance(duration_s, int | float) and _SMALLEST_S <= duration_s < math.inf):
        raise ValueRefused(
            f"a duration of {duration_s!r} s, a number of seconds above 0 is expected; nothing was sent"
        )


def _clock_of(connection: Connection) -> Any:
    """Return the drive's time on the host's clock, where a stream is running that tells it."""
    return lambda: None if connection.stream is None else connection.stream.clock
