"""The paper's own experiments, one file each, with `run(pieces, out) → metrics`, and their pictures."""
