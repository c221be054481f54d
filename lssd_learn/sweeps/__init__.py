"""What many runs have left, read and summed up: of whatever launcher, and also where some of them failed."""
