"""Workspaces: what a robot can hold, reach and pass."""
