"""Two shapes matched as they lie, step by step: prepared → features → starts → spectral → bending → surface → measures.

`maps/match.py` puts the steps together.
"""
