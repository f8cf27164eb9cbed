"""Simulate and analyse cable-driven parallel robots."""

__version__ = "0.1.0"
