"""Interpreter of G-code, and the path of a program."""
