"""Warnings of a simulation about unreliable results: steps that did not converge, inverted tets."""

import warnings

import numpy as np
import pytest

import palpate


def block():
    """A model of one block of 3^3 cells of 0.1 m, held at a corner."""
    model = palpate.Model()
    model.add_body(*palpate.box((3, 3, 3), (0.1, 0.1, 0.1)), material=palpate.Material(young_modulus=2e4), fixed=[0])
    return model


def test_steps_that_do_not_converge_are_counted_and_warned_of():
    hasty = palpate.Simulation(block(), solver={"preconditioner": "jacobi", "max_iterations": 1, "max_substeps": 1})
    with pytest.warns(palpate.NotConverged, match=r"NOT CONVERGED in \d+ of 5 steps: do not trust positions"):
        hasty.run(5)
    assert 0 < hasty.steps_not_converged <= 5
    assert not hasty.metrics.solver_converged
    good = palpate.Simulation(block())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        good.run(5)
    assert good.steps_not_converged == 0
    assert (good.metrics.inverted_tets, good.most_inverted_tets) == (0, 0)


def test_tets_that_are_inside_out_are_counted():
    """The top of a tet is pushed through its fixed base."""
    model = palpate.Model()
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    model.add_body(points, [[0, 1, 2, 3]], material=palpate.Material(young_modulus=1e3), fixed=[0, 1, 2],
                   velocity=(0, 0, -150))
    simulation = palpate.Simulation(model, gravity=(0, 0, 0))
    simulation.run(1)
    assert simulation.positions[3, 2] < 0
    assert (simulation.metrics.inverted_tets, simulation.most_inverted_tets) == (1, 1)
