"""The live view: what a drive does, in Rerun, while it does it; and recorded runs in the same panels."""

from benchtool.live.bundle import setup_of, show_bundle
from benchtool.live.names import CAPTURE, STREAM, TRANSDUCER
from benchtool.live.panels.documents import certificate_document, results_document
from benchtool.live.sinks.file import FileDestination
from benchtool.live.sinks.outlet import Destination, Outlet
from benchtool.live.sinks.viewer import LOOPBACK, Viewer
from benchtool.live.view import LiveView, Setup

__all__ = [
    "CAPTURE",
    "LOOPBACK",
    "STREAM",
    "TRANSDUCER",
    "Destination",
    "FileDestination",
    "LiveView",
    "Outlet",
    "Setup",
    "Viewer",
    "certificate_document",
    "results_document",
    "setup_of",
    "show_bundle",
]
