"""The subcommands of ``fullbody``, one per file, each with a function ``register(subparsers)``."""
