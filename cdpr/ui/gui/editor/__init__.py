"""Editor of a scenario and its robot: as YAML texts, as a form, and as a scenario to run.

- `tree`, `edit`: edits in a YAML text that preserve its formatting;
- `files`: texts and files on disk;
- `fields`, `table`, `form`: form generated from the schema;
- `choose`, `nominal`: conversion of form edits into data;
- `editor`: composition of all parts.
"""

from cdpr.ui.gui.editor.editor import Editor

__all__ = ["Editor"]
