"""Interactive pictures of runs in 3D with WebGL: a page without server or network, and sliders in a notebook."""

from .explorer import CURVES, Explorer, explore
from .page import View, view

__all__ = ["CURVES", "Explorer", "View", "explore", "view"]
