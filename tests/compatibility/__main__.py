"""Renew the snapshots of what a version promises, at a release: python -m tests.compatibility."""

from __future__ import annotations

from tests.compatibility.promises import renew

if __name__ == "__main__":
    renew()
