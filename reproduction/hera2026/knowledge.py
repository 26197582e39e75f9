"""One table: what is known of the pair today, and what would be after two weeks of Hera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import mission, model

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray

__all__ = ["moments", "of_member", "table"]


def of_member(row: xarray.Dataset) -> mission.Truth:
    """Return the pair of a member at arrival."""
    figure = {name: float(row[name]) for name in ("equatorial", "polar", "diameter")}
    big, small = model.masses(float(row.separation), density=float(row.density), **figure)
    return mission.Truth(big, small, **figure, a_b=float(row.a_b), b_c=float(row.b_c), state=row.state.values)


def moments(a_b: Any, b_c: Any) -> npt.NDArray[np.float64]:
    """Return (B - A)/C, (C - A)/B and (C - B)/A of homogeneous ellipsoids (..., 3)."""
    a, b, c = (np.asarray(a_b) * b_c) ** 2, np.asarray(b_c) ** 2, 1.0
    return np.stack([(a - b) / (a + b), (a - c) / (a + c), (b - c) / (b + c)], axis=-1)


def table(dataset: xarray.Dataset, truth: mission.Truth, fit: Any) -> dict[str, Any]:
    """Return standard errors today, which are the scatter of the members, and after the survey.

    The fitted figure of Dimorphos has the volume of the truth, so that its two ratios stand for its moments of inertia.
    The change of its velocity along the motion, which beta needs beside the mass, stays what is known today.
    """
    columns = {name: dataset[name].values.astype(float) for name in model.NAMES}
    names = ("separation", "equatorial", "polar", "diameter", "density")
    today = np.array([model.masses(*(columns[name][k] for name in names)) for k in range(len(columns["along"]))])
    beta = model.beta(columns["along"], columns["density"], columns["diameter"])
    shapes = moments(columns["a_b"], columns["b_c"])
    draws = np.random.default_rng(1).multivariate_normal(
        [truth.big, truth.small, truth.polar, truth.a_b, truth.b_c],
        _of(fit, ("big", "small", "polar", "a_b", "b_c")),
        4000,
    )
    along = columns["along"].std() / abs(columns["along"].mean())
    share = draws[:, 1].std() / truth.small
    after_shapes = moments(draws[:, 3], draws[:, 4])
    rows = {
        "GM of the pair": ("%", _relative(today.sum(axis=1)), _relative(draws[:, :2].sum(axis=1))),
        "mass of Dimorphos": ("%", _relative(today[:, 1]), share),
        "beta along the motion": ("%", _relative(beta), float(np.hypot(share, along))),
        "polar semi-axis of Didymos, by its J2": ("m", columns["polar"].std(), draws[:, 2].std()),
    }
    for k, name in enumerate(("(B - A)/C", "(C - A)/B", "(C - B)/A")):
        rows[f"{name} of Dimorphos"] = ("", shapes[:, k].std(), after_shapes[:, k].std())
    exact = {"big": truth.big, "small": truth.small, "polar": truth.polar, "a_b": truth.a_b, "b_c": truth.b_c}
    return {
        "closest": _closest(truth),
        "chi2": float(fit.chi2),
        "dof": int(fit.dof),
        "fit minus truth, in errors": {
            name: float((fit.values[name] - true) / fit.sigma[name]) for name, true in exact.items()
        },
        "beta": [float(beta.mean()), float(beta.std())],
        "rows": {
            name: {"unit": unit, "today": _told(today, unit), "after": _told(after, unit)}
            for name, (unit, today, after) in rows.items()
        },
    }


def _of(fit: Any, names: tuple[str, ...]) -> npt.NDArray[np.float64]:
    indices = [list(fit.names).index(name) for name in names]
    return np.asarray(fit.covariance)[np.ix_(indices, indices)]


def _closest(truth: mission.Truth) -> list[float]:
    """Return the least distance of each pass from Didymos, km."""
    setup, values = mission.survey(truth)
    system, state = setup(**values)
    run = system.integrate(state, mission.LENGTH, output=1.0)
    away = np.linalg.norm(run.position[:, 2:] - run.position[:, :1], axis=2)
    return [float(distance) for distance in away.min(axis=0)]


def _relative(values: npt.NDArray[np.float64]) -> float:
    return float(values.std() / abs(values.mean()))


def _told(error: float, unit: str) -> str:
    return f"{100 * error:.2g}" if unit == "%" else f"{error:.2g}"
