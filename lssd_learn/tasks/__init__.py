"""What a run does: one file a task, each with `run(pieces, out) → metrics`."""
