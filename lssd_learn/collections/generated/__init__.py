"""Shapes that nobody scanned: bodies, characters, faces, motions, bumps, and what is made of them."""
