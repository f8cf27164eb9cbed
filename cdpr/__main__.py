"""Entry point of `python -m cdpr`."""

from cdpr.ui.cli import main

main()
