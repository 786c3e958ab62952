"""What a full CAN bus through a serial adapter costs: `python -m benchmarks.slcan [--json] [--seconds N]`.

8000 data frames of 8 bytes a second, what a bus of 1 Mbit/s carries at most, come from an adapter in a
process of its own over a pseudo-terminal, eight every millisecond, as USB delivers them. Measured is the
processor time of the receiving process as a share of one core, and the frames that were lost, for

    link      SlcanBus under a CanopenLink with a subscriber of every frame
    bus       SlcanBus alone
    baseline  python-can's own slcan bus alone, on the same stream

Ratios are of the time per frame that arrived: a receiver that loses frames saves their time.
"""

from __future__ import annotations

import argparse
import json
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import can

from benchmarks.figures import print_figures
from benchtool.clock import RealClock
from benchtool.emulator.ports.pty import PtyPort
from benchtool.emulator.servers.slcan import SlcanAdapter
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.canopen.slcan import open_slcan
from benchtool.link.interface import Frame

RATE_HZ = 8000
BITRATE_BIT_S = 1_000_000
GOAL_PERCENT = 15.0
CAN_IDS = (0x181, 0x281, 0x381, 0x481)
_STEP_S = 1e-3
_END_ID = 0x701
_STAMP = struct.Struct("<LL")
_PATIENCE_S = 10.0


@dataclass
class Tally:
    """Frames that have arrived, and how many are missing by their numbers."""

    received: int = 0
    lost: int = 0
    next_number: int = 0
    ended: bool = False

    def take(self, can_id: int, data: bytes | bytearray) -> None:
        """Count one frame."""
        number = _STAMP.unpack(data)[0]
        self.lost += number - self.next_number
        if can_id == _END_ID:
            self.ended = True
            return
        self.next_number = number + 1
        self.received += 1


def stream(seconds: float) -> None:
    """The adapter's process: print its port, send once its channel is open, print the result."""
    port = PtyPort()
    adapter = SlcanAdapter(port)
    closing = threading.Event()

    def obey() -> None:
        while not closing.is_set():
            adapter.recv(0.05)

    receiver = threading.Thread(target=obey, daemon=True)
    receiver.start()
    print(json.dumps({"path": port.path}), flush=True)
    clock = RealClock()
    wait_until(adapter, is_open=True)
    clock.wait(0.2)
    start_s, number, worst_delay_s = time.monotonic(), 0, 0.0
    while (elapsed_s := time.monotonic() - start_s) < seconds and adapter.is_open:
        due = min(int(elapsed_s * RATE_HZ), int(seconds * RATE_HZ))
        worst_delay_s = max(worst_delay_s, elapsed_s - number / RATE_HZ)
        while number < due:
            send(adapter, CAN_IDS[number % len(CAN_IDS)], number)
            number += 1
        clock.wait(_STEP_S)
    clock.wait(1.0)
    send(adapter, _END_ID, number)
    wait_until(adapter, is_open=False)
    closing.set()
    receiver.join()
    adapter.shutdown()
    outcome = {"sent": number, "dropped_by_adapter": adapter.dropped, "worst_delay_s": worst_delay_s}
    print(json.dumps(outcome))


def wait_until(adapter: SlcanAdapter, *, is_open: bool) -> None:
    """Return when the host has opened or closed the channel.

    Raises:
        TimeoutError: it has not for ten seconds.
    """
    deadline_s = time.monotonic() + _PATIENCE_S
    while adapter.is_open is not is_open:
        if time.monotonic() > deadline_s:
            raise TimeoutError(f"the host did not {'open' if is_open else 'close'} the channel")
        RealClock().wait(0.01)


def send(adapter: SlcanAdapter, can_id: int, number: int) -> None:
    """One numbered frame to the host."""
    data = _STAMP.pack(number, 0xA5A5A5A5)
    adapter.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))


def through_link(path: str, tally: Tally) -> None:
    """Receive by CanopenLink."""
    done = threading.Event()

    def take(frame: Frame) -> None:
        tally.take(frame.can_id, frame.data)
        if tally.ended:
            done.set()

    bus = open_slcan(path, BITRATE_BIT_S)
    with CanopenLink(bus, 1, RealClock()) as link:
        link.subscribe([*CAN_IDS, _END_ID], take)
        done.wait()


def through_bus(bus: can.BusABC, tally: Tally) -> None:
    """Receive by a loop around `recv`."""
    while not tally.ended:
        frame = bus.recv(0.05)
        if frame is not None:
            tally.take(frame.arbitration_id, frame.data)
    bus.shutdown()


def measure(receive: Callable[[str, Tally], None], seconds: float) -> dict[str, float]:
    """Return the processor share and losses of one way to receive."""
    command = [sys.executable, "-m", "benchmarks.slcan", "--stream", str(seconds)]
    tally = Tally()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        path = json.loads(child.stdout.readline())["path"]
        processor_s = time.process_time()
        try:
            receive(path, tally)
            processor_s = time.process_time() - processor_s
            outcome: dict[str, Any] = json.loads(child.stdout.readline())
        except BaseException:
            child.kill()
            raise
    return {
        "cpu_percent": round(100.0 * processor_s / seconds, 2),
        "cpu_us_per_frame": round(1e6 * processor_s / max(1, tally.received), 2),
        "frames_sent": outcome["sent"],
        "frames_received": tally.received,
        "frames_lost": tally.lost,
        "dropped_by_adapter": outcome["dropped_by_adapter"],
        "sender_late_ms": round(1e3 * outcome["worst_delay_s"], 1),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each of the three streams")
    parser.add_argument("--stream", type=float, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.stream is not None:
        stream(arguments.stream)
        return

    def python_can(path: str, tally: Tally) -> None:
        bus = can.Bus(interface="slcan", channel=path, bitrate=BITRATE_BIT_S, sleep_after_open=0.0)
        through_bus(bus, tally)

    seconds = arguments.seconds
    link = measure(through_link, seconds)
    bus = measure(lambda path, tally: through_bus(open_slcan(path, BITRATE_BIT_S), tally), seconds)
    baseline = measure(python_can, seconds)
    result: dict[str, object] = {
        "link": link,
        "bus": bus,
        "baseline_python_can": baseline,
        "bus_over_baseline_per_frame": round(bus["cpu_us_per_frame"] / baseline["cpu_us_per_frame"], 3),
        "link_over_baseline_per_frame": round(link["cpu_us_per_frame"] / baseline["cpu_us_per_frame"], 3),
        "goal_cpu_percent": GOAL_PERCENT,
        "rate_Hz": RATE_HZ,
        "seconds": seconds,
    }
    print_figures(result, as_json=arguments.json)


if __name__ == "__main__":
    main()
