"""Landmarks on shapes as a person checks them: pictures of each, a page, and charts of how far they are off."""
