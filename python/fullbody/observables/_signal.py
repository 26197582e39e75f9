"""Signals of a run: slopes and frequencies, by scipy."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from ..base.units import need
from ..typing import Floats


def scipy_module(name: str) -> Any:
    """Import a module of scipy, or raise an error that says how to install it."""
    with need("analysis", "an observable, or an orbit of a mean period,"):
        return import_module(f"scipy.{name}")


def slope(time: Floats, values: Floats, power: int = 1) -> float:
    """Return a least-squares slope, weighted by a power of a Hann window (Laskar 1993, Physica D 67, 257)."""
    phase = (time - time[0]) / (time[-1] - time[0])
    # The weights are positive at the ends too, so that a few samples suffice.
    weight = np.sin(np.pi * phase) ** (2 * power) + (1e-3 / len(time) if power == 1 else 0.0)
    centred = time - np.average(time, weights=weight)
    return float((weight * centred) @ values / ((weight * centred) @ centred))


def averaged(time: Floats, values: Floats, length: float) -> Floats:
    """Return the averages of values over a length of time about each sample, which is shorter at the ends."""
    t = time if time[-1] > time[0] else -time
    integral = np.concatenate([[0.0], np.cumsum(np.diff(t) * (values[1:] + values[:-1]) / 2)])
    begin, end = np.maximum(t - length / 2, t[0]), np.minimum(t + length / 2, t[-1])
    return np.asarray((np.interp(end, t, integral) - np.interp(begin, t, integral)) / (end - begin))


def is_regular(time: Floats) -> bool:
    """Return whether times are equally spaced."""
    steps = np.diff(time)
    return bool(np.ptp(steps) <= 1e-6 * abs(steps.mean()))


def regular(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return samples at equal steps: the given ones if they are, or else those of a cubic spline through them."""
    if is_regular(time):
        return time, values
    grid = np.linspace(time[0], time[-1], 4 * len(time))
    order = np.argsort(time)
    return grid, scipy_module("interpolate").CubicSpline(time[order], values[order])(grid)


def periodic_terms(time: Floats, values: Floats, count: int) -> tuple[Floats, Floats]:
    """Return the strongest periodic terms of a signal: angular frequencies and amplitudes (half of peak to peak).

    Terms are found one after another: the peak of the Hann-windowed spectrum is refined by maximising the windowed
    Fourier integral (Laskar 1990, Icarus 88, 266), then all terms so far and a constant are fitted together and
    subtracted. Terms closer than two periods in the length of the signal cannot be told apart and count as one.
    """
    optimize, signal = scipy_module("optimize"), scipy_module("signal")
    t, x = regular(time, values)
    t = t - t[0]
    step, window = abs(t[1] - t[0]), signal.windows.hann(len(t), sym=True)
    frequencies: list[float] = []
    amplitudes = np.zeros(0)
    remainder = x - x.mean()
    floor = 1e-13 * max(float(np.abs(x).max()), 1e-300)
    for _ in range(count):
        if np.abs(remainder).max() <= floor:
            break
        size = 4 * len(t)
        spectrum = np.abs(np.fft.rfft(window * (remainder - remainder.mean()), size))
        grid = 2 * np.pi * np.fft.rfftfreq(size, step)
        # A term with less than one period in the run is no periodic one.
        resolution = 2 * np.pi / (step * len(t))
        spectrum[grid < resolution] = 0.0
        for frequency in frequencies:
            spectrum[np.abs(grid - frequency) < 2 * resolution] = 0.0
        if not spectrum.any():
            break
        peak = grid[int(spectrum.argmax())]
        width = grid[1]

        def negative_size(frequency: float, remainder: Floats = remainder) -> float:
            return -float(np.abs(np.sum(window * remainder * np.exp(-1j * frequency * t))))

        maximum = optimize.minimize_scalar(
            negative_size, bounds=(max(peak - 2 * width, 0.5 * width), peak + 2 * width), method="bounded",
            options={"xatol": 1e-12 * peak},
        )  # fmt: skip
        frequencies.append(float(maximum.x))
        waves = [wave(f * t) for f in frequencies for wave in (np.cos, np.sin)]
        basis = np.stack([np.ones_like(t), *waves], axis=1)
        coefficients = np.linalg.lstsq(basis, x, rcond=None)[0]
        remainder = x - basis @ coefficients
        amplitudes = np.hypot(coefficients[1::2], coefficients[2::2])
    return np.array(frequencies), amplitudes
