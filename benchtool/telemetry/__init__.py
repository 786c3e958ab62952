"""The stream on the host: received, decoded, checked and handed to whoever wants it."""

from benchtool.telemetry.certificate import Certificate, StreamFacts, certify, certify_recording
from benchtool.telemetry.clock_fit import ArrivalStatistics, ClockFit
from benchtool.telemetry.fanout import FanOut, Sink
from benchtool.telemetry.frames import FrameLog
from benchtool.telemetry.journal import Journal, keep_journal
from benchtool.telemetry.recorder import STREAM, record_stream
from benchtool.telemetry.setpoints import Setpoints
from benchtool.telemetry.stream import DEFAULT_CHANNELS, DEFAULT_RATE_HZ, StreamReport, TelemetryStream

__all__ = [
    "DEFAULT_CHANNELS",
    "DEFAULT_RATE_HZ",
    "STREAM",
    "ArrivalStatistics",
    "Certificate",
    "ClockFit",
    "FanOut",
    "FrameLog",
    "Journal",
    "Setpoints",
    "Sink",
    "StreamFacts",
    "StreamReport",
    "TelemetryStream",
    "certify",
    "certify_recording",
    "keep_journal",
    "record_stream",
]
