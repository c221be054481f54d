"""What every stage costs, beside a peer's implementation of the same."""
