"""The composition root: profiles and addresses become sessions, the emulated drive a device of its own."""
