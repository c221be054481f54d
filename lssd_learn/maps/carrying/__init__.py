"""Landmarks carried by maps from shapes that have them: each as it lies there, what several say, and how sure it is."""
