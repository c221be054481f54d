"""Landmarks as the programs of the field keep them: a format a file, read and written; `files.py` is the door."""
