"""Graphical user interface: a simulation that is shown and controlled in a browser.

- `show`: thread that owns the simulation and executes commands.
- `stage`: a simulation and its display; `drawing`, `curves`: conversion of its rows for the page.
- `board`: broadcast of the latest data to all windows.
- `server`: HTTP page and WebSockets of the windows, on one port.
- `desk`: editor of the scenario's files as a form.
- `page`: content of the browser page.
- `window`: composition of all parts.
"""
