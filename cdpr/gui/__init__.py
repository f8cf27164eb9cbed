"""`cdpr gui`: a window in the browser that edits, runs and disturbs a scenario."""
