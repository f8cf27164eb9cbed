"""What is edited: the files of a scenario and its robot, as texts, as a form, and as a scenario to run.

- `tree`, `edit`: values in a YAML text, changed where they stand;
- `files`: the texts and what is on the disk;
- `fields`, `table`, `form`: the form, made from the schema;
- `choose`, `believed`: what some edits mean;
- `desk`: all of it together.
"""

from cdpr.gui.desk.desk import Desk

__all__ = ["Desk"]
