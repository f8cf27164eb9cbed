"""The same closed loop on several engines, held against each other and against what is known of their schemes.

- `differences`: how far two runs are apart, quantity by quantity;
- `engines`: who takes part, who judges, and by which standard each is judged;
- `verdict`: one engine's run against its standard;
- `comparison`: runs all of them, each in a process of its own, and judges them; `finished` judges run folders;
- `excitation`: what the scenario never asks of an engine, of which agreement says nothing;
- `refinement`: the measured order;
- `baseline`: what is kept of a run, `baseline_file` where, and `baseline_check` holds a later run against it.
"""
