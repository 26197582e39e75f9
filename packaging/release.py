"""``python packaging/release.py VERSION``: write a version, as Python writes it, into every file that states it.

``make release`` runs it before all checks. A development version, such as 0.4.0.dev0, begins a new section of the
changelog; any other version closes the section Unreleased with the date of today.
"""

from __future__ import annotations

import datetime
import re
import subprocess
import sys
from pathlib import Path

from packaging.version import InvalidVersion, Version

ROOT = Path(__file__).parents[1]
#: For each file, the pattern of its version, which is the pattern's one group.
STATED = {
    "Cargo.toml": r'^version = "(\S+)"$',
    "CITATION.cff": r"^version: (\S+)$",
    "docs/cite.md": r"^  version = \{(\S+)\},$",
    "docs/install.md": r"/dist/fullbody-(\S+?)-cp311",
    "packaging/conda/recipe.yaml": r'^  version: "(\S+)"$',
}


def with_version(text: str, pattern: str, version: str) -> str:
    """Return the text of a file with another version instead of the first one that the pattern matches."""
    match = re.search(pattern, text, re.MULTILINE)
    if match is None:
        raise SystemExit(f"no version matches the pattern {pattern}")
    return text[: match.start(1)] + version + text[match.end(1) :]


def write(version: Version) -> None:
    """Write the version and, for a release, its date."""
    today = datetime.date.today().isoformat()
    for name, pattern in STATED.items():
        path = ROOT / name
        # Cargo writes 0.4.0-dev for Python's 0.4.0.dev0.
        written = str(version).replace(".dev0", "-dev") if path.suffix == ".toml" else str(version)
        text = with_version(path.read_text(encoding="utf-8"), pattern, written)
        if path.suffix == ".cff":
            text = re.sub(r"^date-released: .*\n", "", text, flags=re.MULTILINE)
            if not version.is_devrelease:
                text = text.replace(f"version: {written}\n", f"version: {written}\ndate-released: {today}\n")
        path.write_text(text, encoding="utf-8")
    path = ROOT / "CHANGELOG.md"
    text = path.read_text(encoding="utf-8")
    if version.is_devrelease:
        text = text.replace("## [", "## [Unreleased]\n\n## [", 1)
    else:
        text = text.replace("## [Unreleased]", f"## [{version}] - {today}", 1)
    path.write_text(text, encoding="utf-8")
    for folder in (".", "fuzz"):
        subprocess.run(["cargo", "update", "--workspace"], cwd=ROOT / folder, check=True)


if __name__ == "__main__":
    try:
        write(Version(sys.argv[1]))
    except (IndexError, InvalidVersion):
        raise SystemExit("expected a version, as in: make release VERSION=0.4.0") from None
