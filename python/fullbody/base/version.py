"""The version of the installed package."""


def version() -> str:
    """Return the version as text."""
    # The import of this module takes a third of the package's import time, and few programs need the version.
    from importlib import metadata

    return metadata.version("fullbody")
