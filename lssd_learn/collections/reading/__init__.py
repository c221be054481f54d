"""What stands in a folder of shapes, read and checked piece by piece; `collections/folder.py` puts it together."""
