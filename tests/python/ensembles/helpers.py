"""A user's own module."""


def half(x):
    """Half of it."""
    return x / 2
