"""User interfaces: reports, window, live links and command line."""
