"""Write the address of the project's source into the files that show it: ``make address``.

The address is ``address`` in ``[tool.fullbody]`` of pyproject.toml. If it is empty, the texts that show it are removed.
The site reads it from there.
"""

import re
import sys
import tomllib
from pathlib import Path

#: For each file the line before the address, the text that shows it, and a pattern of this text.
PLACES = {
    "README.md": ("# fullbody\n", "\nSource: <{}>\n", r"\nSource: <[^>]*>\n"),
    "CITATION.cff": ("license: MIT\n", 'repository-code: "{}"\n', r'repository-code: "[^"]*"\n'),
    "pyproject.toml": ('dynamic = ["version"]\n', 'urls = {{ Source = "{}" }}\n', r'urls = \{ Source = "[^"]*" \}\n'),
}


def main(root: Path) -> None:
    """Write the address into the files of a folder."""
    address = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["fullbody"]["address"]
    for name, (preceding, format_, pattern) in PLACES.items():
        path = root / name
        text = re.sub(pattern, "", path.read_text(encoding="utf-8"))
        if address:
            text = text.replace(preceding, preceding + format_.format(address), 1)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(*sys.argv[1:2]) if sys.argv[1:] else Path(__file__).parents[1])
