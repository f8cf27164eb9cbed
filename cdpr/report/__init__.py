"""What people see of results: `text` for terminals, `figures` by matplotlib, and `pages` of both for browsers."""
