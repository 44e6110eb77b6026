"""Stable neo-Hookean statics against a second code: assembled by scikit-fem, solved by Newton's method written here."""

import numpy as np
import pytest
import skfem

import palpate

YOUNG, DENSITY, GRAVITY = 2e5, 1000.0, 9.81


def response(f, nu):
    """P and dP/dF of Smith, de Goes & Kim 2018, eq. 14, as their paper writes it; f is (3, 3, ...)."""
    shear, first = YOUNG / (2 * (1 + nu)), YOUNG * nu / ((1 + nu) * (1 - 2 * nu))
    mu, lam = 4 / 3 * shear, first + 5 / 6 * shear
    alpha = 1 + mu / lam - mu / (4 * lam)
    i1 = np.einsum("ij...,ij...->...", f, f)
    cofactor = np.stack([np.cross(f[:, (k + 1) % 3], f[:, (k + 2) % 3], axis=0) for k in range(3)], axis=1)
    j = np.einsum("i...,i...->...", f[:, 0], cofactor[:, 0])
    stress = mu * (1 - 1 / (i1 + 1)) * f + lam * (j - alpha) * cofactor
    one, levi = np.eye(3), np.zeros((3, 3, 3))
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        levi[a, b, c], levi[a, c, b] = 1.0, -1.0
    tangent = np.einsum("ik,jl,...->ijkl...", one, one, mu * (1 - 1 / (i1 + 1)))
    tangent += 2 * mu / (i1 + 1) ** 2 * np.einsum("ij...,kl...->ijkl...", f, f)
    tangent += lam * np.einsum("ij...,kl...->ijkl...", cofactor, cofactor)
    return stress, tangent + lam * (j - alpha) * np.einsum("ikm,jln,mn...->ijkl...", levi, levi, f)


def statics(points, tets, held, nu):
    """Displacements (n, 3) under gravity along z, by Newton's method with the whole load in steps."""
    from skfem.helpers import ddot, grad

    mesh = skfem.MeshTet(points.T.copy(), tets.T.astype(np.int64))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()), intorder=1)

    @skfem.BilinearForm
    def stiffness(u, v, w):
        f = np.eye(3)[:, :, None, None] + grad(w["displacement"])
        return np.einsum("ij...,ijkl...,kl...->...", grad(v), response(f, nu)[1], grad(u))

    @skfem.LinearForm
    def inner(v, w):
        return ddot(response(np.eye(3)[:, :, None, None] + grad(w["displacement"]), nu)[0], grad(v))

    @skfem.LinearForm
    def weight(v, w):
        return -DENSITY * GRAVITY * v[2]

    fixed = basis.nodal_dofs[:, held].ravel()
    load, displacement = weight.assemble(basis), np.zeros(basis.N)
    for part in np.linspace(0.2, 1.0, 5):
        for _ in range(30):
            residual = part * load - inner.assemble(basis, displacement=basis.interpolate(displacement))
            residual[fixed] = 0.0
            if np.abs(residual).max() < 1e-10 * np.abs(load).max():
                break
            matrix = stiffness.assemble(basis, displacement=basis.interpolate(displacement))
            displacement += skfem.solve(*skfem.condense(matrix, residual, D=fixed))
        else:
            raise AssertionError("no convergence of the second code")
    return displacement[basis.nodal_dofs].T


@pytest.mark.parametrize("nu", [0.3, 0.45])
def test_a_beam_that_hangs_is_where_scikit_fem_has_it(nu):
    points, tets = palpate.box((8, 3, 3), (0.4, 0.1, 0.1))
    points = points + 0.004 * np.sin(40 * points[:, [1, 2, 0]]) * (np.abs(points[:, [0]]) < 0.19)  # no regular mesh
    held = np.flatnonzero(points[:, 0] < -0.2 + 1e-9)
    model = palpate.Model()
    material = palpate.Material(young_modulus=YOUNG, poisson_ratio=nu, density=DENSITY, model="stable-neo-hookean")
    model.add_body(points, tets, material=material, fixed=held)
    settings = {"tolerance": 1e-11, "max_iterations": 20000, "max_solves": 100}
    simulation = palpate.Simulation(model, gravity=(0.0, 0.0, -GRAVITY), time_step=20.0, solver=settings)
    for _ in range(4):
        simulation.step()
    found, expected = simulation.positions - points, statics(points, tets, held, nu)
    assert np.abs(expected).max() > 0.1, "large strains and rotations"
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
