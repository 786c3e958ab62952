"""The live view: what a drive does, in Rerun, while it does it; and recorded runs in the same panels."""

from benchtool.live.bundle import setup_of, show_bundle
from benchtool.live.file import FileDestination
from benchtool.live.names import CAPTURE, STREAM, TRANSDUCER
from benchtool.live.outlet import Destination, Outlet
from benchtool.live.view import LiveView, Setup
from benchtool.live.viewer import LOOPBACK, Viewer
from benchtool.live.words import certificate_document, results_document

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
