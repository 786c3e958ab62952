"""benchtool: a hardware-in-the-loop bench for motor drives."""

__version__ = "0.1.0"
