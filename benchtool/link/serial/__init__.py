"""The host end of a serial line."""
