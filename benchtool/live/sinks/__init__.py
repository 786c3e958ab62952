"""Where the live view goes: viewers and files."""
