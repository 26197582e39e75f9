"""Kepler elements."""
