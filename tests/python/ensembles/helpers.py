"""A module of a user, which functions of sweeps import."""


def half(x):
    """Half of it."""
    return x / 2
