"""The player of every page: a scene in space and plots that follow one time, as data and a script that draws them.

`data` turns runs into the one JSON block of a page; `script` holds the script and its style, inlined when a page is
written. The script is our own and takes nothing from elsewhere.
"""
