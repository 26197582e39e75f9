"""``fullbody completion``: the completion of commands and options for a shell."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.units import need


def register(subparsers: Any, parser: argparse.ArgumentParser) -> None:
    """Add the command, for the parser of all commands."""
    command = subparsers.add_parser(
        "completion",
        help="print the completion for a shell",
        description='Print the completion for a shell. For bash: eval "$(fullbody completion bash)". For zsh: '
        "fullbody completion zsh > a folder of $fpath/_fullbody.",
    )
    command.add_argument("shell", choices=("bash", "zsh", "tcsh"))
    command.set_defaults(run=lambda arguments: run(arguments, parser))


def run(arguments: argparse.Namespace, parser: argparse.ArgumentParser) -> int:
    """Run the command."""
    with need(None, "the completion for a shell"):
        import shtab
    print(shtab.complete(parser, shell=arguments.shell))
    return 0
