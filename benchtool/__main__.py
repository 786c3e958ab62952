"""`python -m benchtool`."""

from benchtool.cli import run

run()
