"""Everything that Ho, Wold, Conway & Poursina (2021) show, run again and laid beside what they print."""

from .page import Report, write_report

__all__ = ["Report", "write_report"]
