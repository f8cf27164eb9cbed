"""Presentation of results: `text` for terminals, `figures` as SVG or matplotlib charts, `pages` as HTML."""
