"""Cook's membrane in plane strain: published values, and quadratic triangles of scikit-fem for other Poisson ratios.

The published value is the vertical displacement of the upper right corner for E = 70, nu = 1/3, F = 100 with linear
elasticity: 32.27 (CalculiX, Elmer), 32.20 (Code_Aster), as the CoFEA benchmark and solids4foam's tutorial give them.
"""

import numpy as np
import pytest
import skfem

import palpate

YOUNG, FORCE, PUBLISHED = 70.0, 100.0, 32.27
LITTLE = 1e-4  # of the force: linear elasticity


def placed(x, y):
    """Of the unit square."""
    return 48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x)


def quadratic(nu, n):
    """The corner's displacement with n x n squares of two quadratic triangles each."""
    from skfem.helpers import ddot, sym_grad, trace

    square = skfem.MeshTri.init_tensor(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1))
    mesh = skfem.MeshTri(np.array(placed(*square.p)), square.t)
    element = skfem.ElementVector(skfem.ElementTriP2())
    basis = skfem.Basis(mesh, element, intorder=4)
    edge = skfem.FacetBasis(mesh, element, facets=mesh.facets_satisfying(lambda p: p[0] > 48 - 1e-9), intorder=4)
    mu, lam = YOUNG / (2 * (1 + nu)), YOUNG * nu / ((1 + nu) * (1 - 2 * nu))

    @skfem.BilinearForm
    def stiffness(u, v, w):
        return 2 * mu * ddot(sym_grad(u), sym_grad(v)) + lam * trace(sym_grad(u)) * trace(sym_grad(v))

    @skfem.LinearForm
    def shear(v, w):
        return FORCE / 16 * v[1]

    held = basis.get_dofs(lambda p: p[0] < 1e-9)
    solution = skfem.solve(*skfem.condense(stiffness.assemble(basis), shear.assemble(edge), D=held))
    corner = np.argmin(np.hypot(mesh.p[0] - 48, mesh.p[1] - 60))
    return solution[basis.nodal_dofs[1, corner]]


def tets(nu, n, **options):
    """The same with n x n x 1 cells of tets whose points do not leave their planes."""
    points, cells = palpate.box((n, n, 1), (1.0, 1.0, 1.0))
    depth = 48.0 / n
    x, y = placed(points[:, 0] + 0.5, points[:, 1] + 0.5)
    points = np.column_stack([x, y, depth * points[:, 2]])
    fixed = np.zeros((len(points), 3), bool)
    fixed[:, 2] = True
    fixed[x < 1e-9] = True
    model = palpate.Model()
    body = model.add_body(points, cells, fixed=fixed, material=palpate.Material(
        young_modulus=YOUNG, poisson_ratio=nu, density=1e-6, **options))
    right = x > 48 - 1e-9
    model.load_surface(body, right, traction=(0.0, LITTLE * FORCE / 16, 0.0))
    # Without gravity, and with next to no mass, the speed that the load alone would give says nothing of how small an
    # error is; Jacobi's estimate does not go by it.
    solver = {"tolerance": 1e-9, "max_iterations": 20000, "preconditioner": "jacobi"}
    simulation = palpate.Simulation(model, gravity=(0.0, 0.0, 0.0), time_step=1e4, solver=solver)
    for _ in range(3):
        simulation.step()
    corner = np.argmin(np.hypot(x - 48, y - 60))
    return (simulation.positions - points)[corner, 1] / LITTLE


def test_the_second_code_has_the_published_value():
    assert abs(quadratic(1 / 3, 48) / PUBLISHED - 1) < 3e-3


@pytest.mark.parametrize("nu", [0.3, 1 / 3])
def test_the_tip_goes_to_the_published_value(nu):
    reference = quadratic(nu, 48) if nu != 1 / 3 else PUBLISHED
    errors = np.array([tets(nu, n) for n in (8, 16, 32)]) / reference - 1
    print("Cook, nu", nu, "errors", errors)
    assert abs(errors[-1]) < 0.02
    assert abs(errors[0] / errors[1]) > 2.5 and abs(errors[1] / errors[2]) > 2.5


@pytest.mark.parametrize("nu", [0.3, 0.49, 0.499])
def test_smoothed_tets_do_not_lock(nu):
    reference = quadratic(nu, 48)
    smoothed = np.array([tets(nu, n, elements="smoothed") for n in (8, 16, 32)]) / reference - 1
    linear = tets(nu, 32) / reference - 1
    print("Cook, nu", nu, "errors of smoothed tets", smoothed, "of linear ones", linear)
    assert abs(smoothed[-1]) < 0.02
    assert abs(smoothed[-1]) < abs(linear)
