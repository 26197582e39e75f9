"""The response of a radar receiver: how much of an echo at one frequency or delay each bin takes."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.kinds import choice
from ..base.units import need
from ..typing import Floats

#: The responses in frequency and in delay; a rectangle is the bin itself.
FREQUENCY_RESPONSES, DELAY_RESPONSES = ("bin", "sinc2"), ("bin", "triangle2")
#: The number of cells to the narrowest bin on which an echo is computed before it is weighted.
_CELLS = 16


def check(frequency: Any, delay: Any = "bin") -> None:
    """Raise an error for a response that does not exist."""
    choice(frequency, "frequency_response", FREQUENCY_RESPONSES)
    choice(delay, "delay_response", DELAY_RESPONSES)


def cells(edges: Floats, span: tuple[float, float]) -> Floats:
    """Return the edges of cells that cover a span, within which the echo lies, with sixteen cells to a bin."""
    width = float(np.diff(edges).min()) / _CELLS
    first, last = np.floor(span[0] / width) - 1.0, np.ceil(span[1] / width) + 1.0
    return np.asarray(width * np.arange(first, last + 1.0))


def weights(response: str, edges: Floats, parts: Floats) -> Floats:
    """Return the weights (B, C) of the echo in C cells in each of B bins.

    A response is a function of the distance from the middle of a bin in units of its width, with the integral one; its
    mean over a cell is exact.
    """
    middle, width = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    x = (parts - middle[:, None]) / width[:, None]
    integral = _integral_of_sinc2(x) if response == "sinc2" else _integral_of_triangle2(x)
    return np.asarray(np.diff(integral, axis=1) / np.diff(parts) * width[:, None])


def _integral_of_sinc2(x: Floats) -> Floats:
    """Return the integral from zero of sinc^2, the power response of a discrete Fourier transform."""
    with need("observing", "the response sinc2"):
        from scipy.special import sici

    return np.asarray(sici(2.0 * np.pi * x)[0] / np.pi - x * np.sinc(x) ** 2)


def _integral_of_triangle2(x: Floats) -> Floats:
    """Return the integral of 3/2 (1 - abs(x))^2, the power response of a decoder to a code of binary phases."""
    half = 0.5 * np.clip(1.0 - np.abs(x), 0.0, None) ** 3
    return np.where(x < 0.0, half, 1.0 - half)
