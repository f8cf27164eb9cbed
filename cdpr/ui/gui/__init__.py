"""Graphical user interface: a simulation that is shown and controlled in a browser.

- `driver`: thread that owns the simulation and executes commands.
- `session`: a simulation and its display; `drawing`, `curves`: conversion of its rows for the page.
- `broadcast`: latest data for all windows.
- `server`: HTTP page and WebSockets of the windows, on one port.
- `editor`: editor of the scenario's files as a form.
- `page`: content of the browser page.
- `window`: composition of all parts.
"""
