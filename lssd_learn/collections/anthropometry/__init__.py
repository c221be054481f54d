"""What a tape measure says of a generated body, see `measures.py`."""
