"""``python -m fullbody``."""

from .cli import main

raise SystemExit(main())
