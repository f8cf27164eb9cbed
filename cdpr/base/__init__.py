"""Foundations: errors, problems, units, fields, columns, tolerances, files, locks and processes."""
