"""``fullbody init``: a description of a ready-made system, to be changed and run."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.tables import Table, to_text
from ..systems import _files

_HEAD = """\
# {title}.
#
#     fullbody run FILE.toml             integrates this system, with the options of [run] and [integrator]
#     fullbody.read_toml("FILE.toml")    reads it in Python
#
# A number is in the units of [system], radians for angles; a text such as "2.5 km" names its own unit. A published
# number may be a table: its value and unit count, and its error, source and doubt are notes. The tables title, text,
# example, assumed, sources, variants, parameters, sun and not_used are notes too. The page "Running" of the
# documentation lists all keys.

"""


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "init",
        help="print the description of a ready-made system, a system.toml",
        description="Print the description of a ready-made system, to be changed: fullbody init didymos > a.toml. "
        "Without a name, list the systems.",
    )
    parser.add_argument("name", nargs="?", choices=_files.names(), metavar="NAME", help="such as didymos")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    if arguments.name is None:
        rows = [(name, str(_files.contents(name)["title"])) for name in _files.names()]
        print(to_text(Table("Ready-made systems", (), list(rows))))
    else:
        content = _files.path(arguments.name).read_text(encoding="utf-8")
        print(_HEAD.format(title=_files.contents(arguments.name)["title"]) + content, end="")
    return 0
