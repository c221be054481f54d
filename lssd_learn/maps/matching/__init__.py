"""Two shapes matched as they lie: prepared → features → starts → bending → surface → measures.

`maps/match.py` puts the steps together.
"""
