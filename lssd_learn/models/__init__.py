"""A trained model as one object: what a checkpoint holds, put in, read out and asked."""
