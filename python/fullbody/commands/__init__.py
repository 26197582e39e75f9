"""The subcommands of ``fullbody``: one file each, with ``register(subparsers)``."""
