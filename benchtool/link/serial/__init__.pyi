from .discovery import scan_port as scan_port
from .link import SerialLink as SerialLink
