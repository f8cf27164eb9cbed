"""What people see of results: `text` for terminals, `figures` as SVG or by matplotlib, `pages` of both for browsers."""
