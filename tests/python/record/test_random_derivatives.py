"""Derivatives of random systems of all kinds agree with differences of complete runs."""

import os

import pytest
from support.random_systems import TOLERANCE, asymmetry, case, errors

#: How many are tried; the acceptance run takes 200 and more, from another first seed.
COUNT = int(os.environ.get("FULLBODY_RANDOM_SYSTEMS", "4"))
FIRST = int(os.environ.get("FULLBODY_FIRST_SEED", "1"))


@pytest.mark.parametrize("seed", range(FIRST, FIRST + COUNT))
def test_derivatives_of_random_systems_are_differences_of_runs(seed):
    tried = case(seed)
    for name, error in errors(tried).items():
        assert error < TOLERANCE, f"{name}: {tried.label}"
    if tried.is_hamiltonian:
        assert asymmetry(tried) < 1e-9, tried.label
