"""Mean surfaces and what changes them: the coordinates of all shapes as functions on the latent shape."""
