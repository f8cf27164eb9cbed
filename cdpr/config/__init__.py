"""Strict YAML with positions, messages, and validation by schemas: shared by scenarios, studies and designs."""
