"""Binaries beyond Neptune: the published astrometry fitted again, with a verdict on each published number."""
