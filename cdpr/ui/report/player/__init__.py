"""Interactive player of HTML pages: a 3D scene and plots on one time axis.

`data` converts runs into the JSON block of a page. The folder `script` holds the JavaScript and CSS, which are inlined
into each page. The script has no dependencies.
"""
