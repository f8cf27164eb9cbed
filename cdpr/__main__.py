"""Entry point of `python -m cdpr`."""

from cdpr.cli import main

main()
