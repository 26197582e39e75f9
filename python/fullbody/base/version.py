"""The version of the installed package."""

__all__ = ["version"]


def version() -> str:
    """The version as text."""
    # The package's metadata takes a third of the import's time, and few ask for it.
    from importlib import metadata

    return metadata.version("fullbody")
