"""The version of the installed package, and the names of optional packages to install."""

#: Whether package indices have this package under its name. Until then, messages name the packages that are missing
#: instead of the extras that contain them.
PUBLISHED = False


def version() -> str:
    """Return the version as text."""
    # The import of this module takes a third of the package's import time, and few programs need the version.
    from importlib import metadata

    return metadata.version("fullbody")


def to_install(package: str, extra: str | None) -> str:
    """Return the argument of pip for a missing package: the ``extra`` that contains it, or the package itself."""
    return f"'fullbody[{extra}]'" if PUBLISHED and extra else package
