"""The body model behind all generated bodies: its cache, its parts, its poses, what grows on it."""
