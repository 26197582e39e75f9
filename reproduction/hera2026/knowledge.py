"""The table of standard errors of the pair today, and after two weeks of Hera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from . import mission, model

if TYPE_CHECKING:
    import numpy.typing as npt
    import xarray

__all__ = ["moments", "table", "truth_of_member"]


def truth_of_member(row: xarray.Dataset) -> mission.Truth:
    """Return the pair of a member at arrival, for a simulation."""
    figure = {name: float(row[name]) for name in ("equatorial", "polar", "diameter")}
    masses = model.masses(float(row.separation), density=float(row.density), **figure)
    return mission.Truth(*masses, **figure, a_b=float(row.a_b), b_c=float(row.b_c), state=row.state.values)


def moments(a_b: Any, b_c: Any) -> npt.NDArray[np.float64]:
    """Return (B - A)/C, (C - A)/B and (C - B)/A of homogeneous ellipsoids (..., 3)."""
    a, b, c = (np.asarray(a_b) * b_c) ** 2, np.asarray(b_c) ** 2, 1.0
    return np.stack([(a - b) / (a + b), (a - c) / (a + c), (b - c) / (b + c)], axis=-1)


def table(dataset: xarray.Dataset, truth: mission.Truth, fit: Any) -> dict[str, Any]:
    """Return standard errors today, which are the scatter of the members, and after the survey.

    The fitted figure of Dimorphos has the volume of the truth, so that its two ratios determine its moments of inertia.
    The change of its velocity along the motion, which beta depends on beside the mass, has the error of today.
    """
    columns = {name: dataset[name].values.astype(float) for name in model.NAMES}
    names = ("separation", "equatorial", "polar", "diameter", "density")
    today = np.array([model.masses(*(columns[name][k] for name in names)) for k in range(len(columns["along"]))])
    beta = model.beta(columns["along"], columns["density"], columns["diameter"])
    shapes = moments(columns["a_b"], columns["b_c"])
    draws = np.random.default_rng(1).multivariate_normal(
        [getattr(truth, name) for name in mission.FITTED],
        _covariance(fit, mission.FITTED),
        4000,
    )
    velocity_error = columns["along"].std() / abs(columns["along"].mean())
    mass_error = draws[:, 1].std() / truth.secondary_mass
    survey_shapes = moments(draws[:, 3], draws[:, 4])
    rows = {
        "GM of the pair": ("%", _relative(today.sum(axis=1)), _relative(draws[:, :2].sum(axis=1))),
        "mass of Dimorphos": ("%", _relative(today[:, 1]), mass_error),
        "beta along the motion": ("%", _relative(beta), float(np.hypot(mass_error, velocity_error))),
        "polar semi-axis of Didymos, by its J2": ("m", columns["polar"].std(), draws[:, 2].std()),
    }
    for k, name in enumerate(("(B - A)/C", "(C - A)/B", "(C - B)/A")):
        rows[f"{name} of Dimorphos"] = ("", shapes[:, k].std(), survey_shapes[:, k].std())
    return {
        "closest": _closest(truth),
        "chi2": float(fit.chi2),
        "dof": int(fit.dof),
        "fit minus truth, in errors": {
            name: float((fit.values[name] - getattr(truth, name)) / fit.sigma[name]) for name in mission.FITTED
        },
        "beta": [float(beta.mean()), float(beta.std())],
        "rows": {
            name: {"unit": unit, "today": _text(today, unit), "after": _text(with_hera, unit)}
            for name, (unit, today, with_hera) in rows.items()
        },
    }


def _covariance(fit: Any, names: tuple[str, ...]) -> npt.NDArray[np.float64]:
    indices = [list(fit.names).index(name) for name in names]
    return np.asarray(fit.covariance)[np.ix_(indices, indices)]


def _closest(truth: mission.Truth) -> list[float]:
    """Return the smallest distance of each pass from Didymos, km."""
    setup, values = mission.survey(truth)
    system, state = setup(**values)
    run = system.integrate(state, mission.LENGTH, output=1.0)
    distance = np.linalg.norm(run.position[:, 2:] - run.position[:, :1], axis=2)
    return [float(smallest) for smallest in distance.min(axis=0)]


def _relative(values: npt.NDArray[np.float64]) -> float:
    return float(values.std() / abs(values.mean()))


def _text(error: float, unit: str) -> str:
    return f"{100 * error:.2g}" if unit == "%" else f"{error:.2g}"
