"""Results of analyses say in one line what they are, and show their numbers as tables."""

import fullbody
import numpy as np
import pytest
from fullbody import analysis


@pytest.fixture(scope="module")
def results(ellipsoids, locked):
    """A result of each kind, by the name of its class."""
    crossing = fullbody.events.PlaneCrossing(1, normal=[0.0, 1.0, 0.0])
    run = ellipsoids.integrate(locked.state, 800.0, output=4.0)
    equilibria = analysis.equilibria(ellipsoids, locked.angular_momentum)
    parts = (
        locked,
        locked.modes,
        analysis.periodic_family(locked, 3, [0.01])[0],
        equilibria,
        equilibria.touching[0],
        branch := analysis.branch(locked, "separation", until=0.9),
        branch.folds[0],
        analysis.section(ellipsoids, locked.state, 200.0, crossing),
        analysis.frequencies(run, run.position[:, 1, 0], n=1),
    )
    return {type(part).__name__: part for part in parts}


#: Parts of the texts. The ellipsoids with their long axes in line touch at 1 + 0.5, where their branch ends.
TEXTS = {
    "RelativeEquilibrium": "RelativeEquilibrium(separation=4, period={period:.8g}, A and B locked; ",
    "Modes": "Modes(7, frequency=[",
    "PeriodicOrbit": "linearly stable)",
    "Equilibria": " apart, {touching} touching, angular_momentum={momentum:.8g}, least: ",
    "Touching": "Touching(separation={contact}, energy=",
    "Branch": " equilibria, separation 4 to 1.5, 1 fold, end='contact')",
    "Fold": "Fold(angular_momentum=",
    "Section": "Section(",
    "Frequencies": "{rate:.5g}",
}


@pytest.mark.parametrize("name", TEXTS)
def test_a_text_names_the_result_and_its_numbers(name, results):
    equilibrium, equilibria, touching = (results[kind] for kind in ("RelativeEquilibrium", "Equilibria", "Touching"))
    sums = [round(a + b, 8) for a in (1.0, 0.9, 0.8) for b in (0.5, 0.42, 0.37)]
    assert min(abs(touching.separation - each) for each in sums) < 1e-12
    facts = {
        "period": 2.0 * np.pi / equilibrium.rate,
        "touching": len(equilibria.touching),
        "momentum": equilibrium.angular_momentum,
        "contact": round(touching.separation, 8),
        "rate": equilibrium.rate,
    }
    text = repr(results[name])
    assert text.startswith(f"{name}(")
    assert TEXTS[name].format(**facts) in text


@pytest.mark.parametrize("name", [name for name in TEXTS if name not in ("Fold", "Frequencies")])
def test_a_table_has_as_many_cells_in_each_row(name, results):
    for table in results[name]._tables():
        assert table.rows
        assert len({len(row) for row in [*table.rows, *([table.header] if table.header else [])]}) == 1
    assert results[name]._repr_html_().count("<table>") == len(results[name]._tables())
