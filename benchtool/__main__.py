"""`python -m benchtool`."""

from benchtool.cli import main

main()
