"""Whether the texts of a figure can be read: they do not cover each other, are inside the figure and large enough."""

import itertools

import numpy as np
from matplotlib.axes import Axes
from matplotlib.text import Text
from matplotlib.ticker import NullFormatter


def texts_of(ax):
    """Titles, labels, shown tick labels, annotations and legend of axes."""
    yield from (ax.title, ax._left_title, ax._right_title, *ax.texts)
    for axis in ax._axis_map.values():
        yield axis.label
        if not hasattr(ax, "get_zlim"):
            yield from (tick.label1 for tick in axis._update_ticks() if tick.label1.get_visible())
    if ax.get_legend():
        yield from ax.get_legend().get_texts()


def text_boxes(figure):
    """Boxes of all texts that a figure shows."""
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    texts = [text for ax in figure.axes for text in texts_of(ax) if text.get_text().strip()]
    texts += [figure._suptitle] if figure._suptitle else []
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in texts]
    # A legend's lines count too, beside the titles.
    for ax in figure.axes:
        handles = ax.get_legend() and ax.get_legend().legend_handles[0].get_window_extent(renderer)
        boxes += [(f"lines of the legend of {ax.get_title(loc='left')}", handles)] if handles and handles.width else []
    return boxes


def faults(figure):
    """Pairs of texts that cover each other by more than a pixel, and texts that stand out of the figure."""
    boxes = text_boxes(figure)
    covering = []
    for (a, x), (b, y) in itertools.combinations(boxes, 2):
        if min(x.x1, y.x1) - max(x.x0, y.x0) > 1.0 and min(x.y1, y.y1) - max(x.y0, y.y0) > 1.0:
            covering.append((a, b))
    width, height = figure.canvas.get_width_height()
    cut = [text for text, box in boxes if box.x0 < -1 or box.y0 < -1 or box.x1 > width + 1 or box.y1 > height + 1]
    return covering, cut


def small(figure):
    """Texts of a figure of less than 8 points."""
    figure.draw_without_rendering()
    texts = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return {text.get_text() for text in texts if text.get_fontsize() < 8.0}


def without_text(figure):
    """The figure with its texts and legends hidden, whose sizes and thus its layout differ between versions."""
    for ax in figure.findobj(Axes):
        ax.get_legend() and ax.get_legend().set_visible(False)
        for axis in ax._axis_map.values():
            axis.set_major_formatter(NullFormatter())
            axis.set_minor_formatter(NullFormatter())
        if hasattr(ax, "get_zlim"):
            # The box in 3D has the size for which there is room beside the texts.
            ax.set_box_aspect(np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1))
    for text in figure.findobj(Text):
        text.set_visible(False)
        text.set_in_layout(False)
    return figure
