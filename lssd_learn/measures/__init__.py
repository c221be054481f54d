"""How good something is, against a known truth: one file a measure, each with `run(pieces, out) → metrics`."""
