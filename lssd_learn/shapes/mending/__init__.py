"""The parts of `clean`: what is told by which vertices lie at one place, and by which way faces turn."""
