"""The drive as the host sees it: names and SI values, states, capture, supervision."""

from benchtool.drive.capture import Capture, CaptureRequest
from benchtool.drive.identity import Identity
from benchtool.drive.player import play
from benchtool.drive.remote import RemoteDrive
from benchtool.drive.stimulus import Stimulus
from benchtool.protocol.modes import Mode

__all__ = ["Capture", "CaptureRequest", "Identity", "Mode", "RemoteDrive", "Stimulus", "play"]
