"""The window: a page in the browser, and what it shows and steers.

- `show`: the thread that owns the simulation, and what it does when told.
- `stage`: one simulation, and what is seen of it; `drawing`, `curves`: what of its rows goes to the page.
- `board`: the latest of everything, which each window takes at its own pace.
- `server`: the page by HTTP, and the sockets of the windows, on one port.
- `desk`: the files that are edited, as a form.
- `page`: what the browser shows.
- `window`: joins them all.
"""
