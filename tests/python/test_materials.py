"""Laws of elasticity and fibres from Python, with closed forms and a second code as oracles."""

import copy
import pickle
import runpy

import numpy as np
import pytest

import palpate

FIBRES = dict(direction=(1.0, 0.0, 0.0), stiffness=1e4, exponent=1.0, active_stress=1e4)


def test_materials_say_what_they_are_and_survive_pickling():
    material = palpate.Material(
        model="stable-neo-hookean", poisson_ratio=0.45, fibres=palpate.Fibres(**FIBRES, activation=palpate.Ramp([0, 1], [0, 1]))
    )
    for other in (pickle.loads(pickle.dumps(material)), copy.copy(material)):
        assert other.model == "stable-neo-hookean"
        assert other.fibres.stiffness == 1e4
        assert other.fibres.activation.factors == [0.0, 1.0]
    assert palpate.Material().model == "corotational" and palpate.Material().fibres is None
    assert "model='stable-neo-hookean'" in repr(material)


def test_bad_values_are_refused_in_one_line_with_the_bound():
    with pytest.raises(palpate.Error, match="stable-neo-hookean"):
        palpate.Material(model="neo")
    with pytest.raises(palpate.Error, match="fibres.*corotational"):
        palpate.Material(fibres=palpate.Fibres(**FIBRES))
    with pytest.raises(palpate.Error, match="poisson_ratio: found -0.1, expected a number > 0"):
        palpate.Material(model="mooney-rivlin", mooney_fraction=1.0, poisson_ratio=-0.1)
    with pytest.raises(palpate.Error, match="active_stress"):
        palpate.Fibres(active_stress=-1.0)
    with pytest.raises(palpate.Error, match="direction"):
        palpate.Fibres(direction=(0.0, 0.0, 0.0), stiffness=1.0)


def test_tissues_are_presets_that_can_be_changed():
    liver = palpate.Material.tissue("liver")
    assert liver.model == "stable-neo-hookean" and liver.density == 1060.0 and 5e3 < liver.young_modulus < 7e3
    liver.young_modulus = 1e4
    assert pickle.loads(pickle.dumps(liver)).young_modulus == 1e4
    with pytest.raises(palpate.Error, match="expected 'liver'"):
        palpate.Material.tissue("livre")


def test_a_field_of_the_mesh_file_is_what_set_fibres_does(tmp_path):
    """Fibres that differ from tet to tet, and a hexahedron that is cut into tets; the same bits."""
    import meshio

    points, tets = palpate.box((3, 2, 2), (0.3, 0.2, 0.2))
    more = np.array([[x, y, z] for z in (0.0, 0.1) for x, y in ((0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1))]) + [1.0, 0.0, 0.0]
    cells = [("hexahedron", np.arange(8)[None] + len(points)), ("tetra", tets)]
    field = np.random.default_rng(5).normal(size=(1 + len(tets), 3))
    meshio.write(tmp_path / "a.vtu", meshio.Mesh(np.vstack([points, more]), cells, cell_data={"way": [field[:1], field[1:]]}))
    material = {"model": "stable-neo-hookean", "fibres": {"stiffness": 1e4, "exponent": 1, "active_stress": 2e4, "field": "way"}}
    scene = {"time_step": 0.01, "bodies": [{"mesh": str(tmp_path / "a.vtu"), "material": material}]}
    by_field = palpate.Simulation(scene)
    del material["fibres"]["field"]
    model = palpate.Model.from_scene(scene)
    count = model.bodies[0].tets.stop
    assert count > len(tets) + 4
    model.set_fibres(0, np.vstack([np.repeat(field[:1], count - len(tets), axis=0), field[1:]]))
    by_hand, plain = palpate.Simulation(model, time_step=0.01), palpate.Simulation(scene)
    for simulation in (by_field, by_hand, plain):
        simulation.run(10)
    assert (by_field.positions == by_hand.positions).all() and (by_field.positions != plain.positions).any()
    material["fibres"]["field"] = "away"
    with pytest.raises(palpate.Error, match="fibres.field.*no cell data of the name 'away'"):
        palpate.Simulation(scene)


FORMATS = [("a.vtu", {}), ("a.vtk", {"file_format": "vtk42", "binary": True}), ("a.vtk", {"file_format": "vtk42", "binary": False}),
           ("a.vtk", {"file_format": "vtk51", "binary": True}), ("a.msh", {"file_format": "gmsh22", "binary": True}), ("a.msh", {"file_format": "gmsh", "binary": True})]


@pytest.mark.parametrize(("name", "options"), FORMATS)
def test_a_field_is_read_from_files_that_meshio_writes(tmp_path, name, options):
    """Two kinds of cells, arrays before and behind the wanted one, and data of points: the same bits as set_fibres()."""
    import meshio

    points, tets = palpate.box((2, 1, 1), (0.2, 0.1, 0.1))
    more = np.array([[x, y, z] for z in (0.0, 0.1) for x, y in ((0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1))]) + [1.0, 0.0, 0.0]
    cells = [("tetra", tets), ("hexahedron", np.arange(8)[None] + len(points))]
    field = np.random.default_rng(5).normal(size=(len(tets) + 1, 3))
    parts = [field[:-1], field[-1:]]
    data = {"number": [np.arange(len(part), dtype=float) for part in parts], "way": parts, "other": [2.0 * part for part in parts]}
    of_points = {"way": np.ones((len(points) + 8, 3))}
    if name.endswith("msh"):
        of_points["gmsh:dim_tags"] = np.array([[3, 1]] * len(points) + [[3, 2]] * 8)
        data |= {tag: [np.full(len(tets), 1), np.full(1, 2)] for tag in ("gmsh:geometrical", "gmsh:physical")}
    meshio.write(tmp_path / name, meshio.Mesh(np.vstack([points, more]), cells, cell_data=data, point_data=of_points), **options)
    fibres = {"stiffness": 1e4, "active_stress": 2e4, "field": "way"}
    scene = {"time_step": 0.01, "bodies": [{"mesh": str(tmp_path / name), "material": {"model": "stable-neo-hookean", "fibres": fibres}}]}
    by_field = palpate.Simulation(scene)
    del fibres["field"]
    model = palpate.Model.from_scene(scene)
    count = model.bodies[0].tets.stop
    model.set_fibres(0, np.vstack([field[:-1], np.repeat(field[-1:], count - len(tets), axis=0)]))
    by_hand = palpate.Simulation(model, time_step=0.01)
    for simulation in (by_field, by_hand):
        simulation.run(3)
    assert (by_field.positions == by_hand.positions).all()
    for wrong, message in (("away", "no cell data of the name 'away'"), ("number", "components|rows")):
        fibres["field"] = wrong
        with pytest.raises(palpate.Error, match=f"fibres.field.*({message})") as caught:
            palpate.Simulation(scene)
        assert "\n" not in str(caught.value)


GMSH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$ElementData
1
"other way"
0
3
0
3
1
7 1 1 1
$EndElementData
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
2
9 4 2 0 0 1 2 3 4
7 4 2 0 0 2 3 4 5
$EndElements
$ElementData
2
"my way"
"x"
1
0.5
4
0
3
2
0
7 1 0 0
9 0 3 4
$EndElementData
$ElementData
1
"my way"
1
1.0
3
1
3
2
7 5 5 5
9 5 5 5
$EndElementData
"""


def test_vectors_of_a_gmsh_file_go_by_the_numbers_of_its_elements(tmp_path):
    """A file written by hand: the first of two time steps is used; missing data is refused in one line."""
    (tmp_path / "a.msh").write_text(GMSH)
    fibres = {"active_stress": 2e4, "field": "my way"}
    scene = {"gravity": [0, 0, 0], "bodies": [
        {"mesh": str(tmp_path / "a.msh"), "material": {"model": "stable-neo-hookean", "fibres": fibres}}]}
    by_field = palpate.Simulation(scene)
    model = palpate.Model.from_scene({**scene, "bodies": [
        {"mesh": str(tmp_path / "a.msh"), "material": {"model": "stable-neo-hookean", "fibres": {"active_stress": 2e4}}}]})
    model.set_fibres(0, [[0.0, 0.6, 0.8], [1.0, 0.0, 0.0]])
    by_hand = palpate.Simulation(model, gravity=(0, 0, 0), time_step=by_field.time_step)
    for simulation in (by_field, by_hand):
        simulation.run(3)
    assert np.abs(by_field.positions - by_hand.positions).max() < 1e-12 * np.abs(by_hand.positions).max()
    fibres["field"] = "other way"
    with pytest.raises(palpate.Error, match="cell data other way, element 9: found nothing, expected a vector for each element"):
        palpate.Simulation(scene)


def test_fibres_between_two_ends_follow_a_bend(tmp_path):
    """A half ring between its cut faces: fibres run around the axis, by set_fibres_between() and by a scene."""
    points, tets = palpate.box((16, 3, 3), (1.0, 1.0, 1.0))
    angle, radius = np.pi * (points[:, 0] + 0.5), points[:, 1] + 2.0
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 2]])
    ends = points[:, 0] < -0.499, points[:, 0] > 0.499
    material = palpate.Material(model="stable-neo-hookean", fibres=palpate.Fibres(active_stress=2e4))

    def run(simulation):
        simulation.run(3)
        return simulation.positions

    model = palpate.Model()
    model.add_body(ring, tets, material=material)
    model.set_fibres_between(0, *ends)
    between = run(palpate.Simulation(model, gravity=(0, 0, 0), time_step=0.01))
    centres = ring[tets].mean(axis=1)
    model.set_fibres(0, np.column_stack([-centres[:, 1], centres[:, 0], np.zeros(len(tets))]))
    around = run(palpate.Simulation(model, gravity=(0, 0, 0), time_step=0.01))
    assert np.abs(between - around).max() < 0.1 * np.abs(around - ring).max()
    with pytest.raises(palpate.Error, match="fibres_between: to: .*ends without a common point"):
        model.set_fibres_between(0, ends[0], ends[0])
    meshio = pytest.importorskip("meshio")
    meshio.write(tmp_path / "ring.vtu", meshio.Mesh(ring, [("tetra", tets)]))
    boxes = [{"box": {"lower": [x - 1, -0.01, -1], "upper": [x + 1, 0.01, 1]}} for x in (2, -2)]
    scene = {"gravity": [0, 0, 0], "time_step": 0.01, "bodies": [{
        "mesh": str(tmp_path / "ring.vtu"), "fibre_ends": {"from": boxes[:1], "to": boxes[1:]},
        "material": {"model": "stable-neo-hookean", "fibres": {"active_stress": 2e4}}}]}
    assert (run(palpate.Simulation(scene)) == between).all()


def test_viscosity_says_what_it_is_and_is_refused_where_it_is_none():
    viscosity = palpate.Viscosity(fractions=[0.3, 0.2], times=[0.1, 2.0])
    material = palpate.Material(viscosity=viscosity)
    for other in (pickle.loads(pickle.dumps(material)), copy.copy(material)):
        assert other.viscosity.fractions == [0.3, 0.2] and other.viscosity.times == [0.1, 2.0]
    assert "viscosity=palpate.Viscosity(fractions=[0.3, 0.2]" in repr(material)
    material.viscosity = None
    assert material.viscosity is None and palpate.Material().viscosity is None
    with pytest.raises(palpate.Error, match="a sum of 1.2, expected a sum < 1"):
        palpate.Viscosity(fractions=[0.6, 0.6], times=[1.0, 2.0])
    with pytest.raises(palpate.Error, match="times.*number > 0"):
        palpate.Viscosity(fractions=[0.6], times=[-1.0])


def test_a_held_stretch_relaxes_as_the_series_says():
    g, tau, h = np.array([0.3, 0.4]), np.array([0.05, 0.4]), 0.02
    points, tets = palpate.box((4, 3, 3), (1.0, 0.75, 0.375))
    viscosity = palpate.Viscosity(fractions=g.tolist(), times=tau.tolist())
    material = palpate.Material(young_modulus=2e4, poisson_ratio=0.0, density=1.0, viscosity=viscosity)  # little inertia
    far = points[:, 0] > 0.5 - 1e-9
    model = palpate.Model()
    body = model.add_body(points, tets, material=material, fixed=points[:, 0] < -0.5 + 1e-9)
    model.prescribe(body, far, palpate.Motion([palpate.Keyframe(0.0), palpate.Keyframe(h, translate=(0.1, 0.0, 0.0))]))
    simulation = palpate.Simulation(model, gravity=(0.0, 0.0, 0.0), time_step=h, solver={"tolerance": 1e-8}, reactions=True)
    forces = []
    for _ in range(30):
        simulation.step()
        forces.append(simulation.reactions[far, 0].sum())
    n = np.arange(10, 30) + 1
    rest = 1 - g.sum()
    expected = 1 + sum(gi / rest * ti / h * (np.exp(-(n - 1) * h / ti) - np.exp(-n * h / ti)) for gi, ti in zip(g, tau))
    assert np.allclose(np.array(forces)[n - 1], 2e4 * 0.75 * 0.375 * 0.1 * expected, rtol=1e-5)


def block(material, **options):
    points, tets = palpate.box((4, 3, 3), (1.0, 0.75, 0.375))
    model = palpate.Model()
    model.add_body(points, tets, material=material, fixed=points[:, 0] < points[:, 0].min() + 1e-9, **options)
    return model, points, tets


def energy(f, young, nu):
    """Smith, de Goes & Kim 2018, eq. 14 with the moduli of their section 3.4, in another form than ours."""
    shear, first = young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))
    mu, lam = 4 / 3 * shear, first + 5 / 6 * shear
    alpha = 1 + mu / lam - mu / (4 * lam)
    i1, j = np.einsum("nij,nij->n", f, f), np.linalg.det(f)
    rest = lam / 2 * (1 - alpha) ** 2 - mu / 2 * np.log(4)
    return mu / 2 * (i1 - 3) + lam / 2 * (j - alpha) ** 2 - mu / 2 * np.log(i1 + 1) - rest


def test_fields_of_stress_and_energy_are_those_of_the_law():
    material = palpate.Material(young_modulus=2e4, poisson_ratio=0.45, model="stable-neo-hookean", stiffness_damping=0.01)
    model, *_ = block(material)
    simulation = palpate.Simulation(model, gravity=(0.0, 0.0, -9.81), time_step=0.02)
    simulation.run(20)
    tissue = simulation.tissue()
    f = np.asarray(tissue.deformation_gradient).reshape(-1, 3, 3)
    np.testing.assert_allclose(tissue.energy_density, energy(f, 2e4, 0.45), rtol=1e-6, atol=1e-6)
    p = np.empty_like(f)
    for i in range(3):
        for j in range(3):
            d = np.zeros((3, 3))
            d[i, j] = 1e-5
            p[:, i, j] = (energy(f + d, 2e4, 0.45) - energy(f - d, 2e4, 0.45)) / 2e-5
    cauchy = p @ f.transpose(0, 2, 1) / np.linalg.det(f)[:, None, None]
    np.testing.assert_allclose(tissue.stress, cauchy, rtol=1e-4, atol=1e-5 * np.abs(cauchy).max())


@pytest.mark.parametrize("test", ["uniaxial", "equibiaxial", "volumetric", "shear"])
def test_stress_of_a_tet_is_the_closed_form_of_the_picture(root, test):
    """The lines and dots of docs/pictures/stretches.png."""
    picture = runpy.run_path(str(root / "docs/pictures/stretches.py"))
    for law, forms in picture["closed_forms"]().items():
        for amount in (0.5, 0.8, 1.0, 1.3, 1.5):
            deformation, expected = forms[test](amount)
            found = picture["computed"](law, test, deformation, amount)
            assert found == pytest.approx(expected, rel=1e-10, abs=1e-10 * picture["YOUNG"]), (law, amount)


def test_a_muscle_contracts_along_its_fibres_and_resumes_from_a_saved_state():
    fibres = palpate.Fibres(direction=(0.0, 1.0, 0.0), active_stress=2e4, activation=palpate.Ramp([0.0, 0.2], [0.0, 1.0]))
    material = palpate.Material(young_modulus=2e4, poisson_ratio=0.45, model="stable-neo-hookean", stiffness_damping=0.01,
                                mass_damping=5.0, fibres=fibres)
    model, points, tets = block(material)
    model.set_fibres(0, np.tile([3.0, 0.0, 0.0], (len(tets), 1)))
    simulation = palpate.Simulation(model, gravity=(0.0, 0.0, 0.0), time_step=0.02)
    simulation.run(15)
    saved = simulation.save()
    simulation.run(15)
    width = np.ptp(simulation.positions, axis=0) / np.ptp(points, axis=0)
    assert width[0] < 0.8 and width[1] > 1.02 and width[2] > 1.02
    other = palpate.Simulation(model, gravity=(0.0, 0.0, 0.0), time_step=0.02)
    other.restore(saved)
    other.run(15)
    assert other.state_hash == simulation.state_hash
    with pytest.raises(palpate.Error, match="one for each tet"):
        model.set_fibres(0, np.zeros((3, 3)))


@pytest.mark.parametrize("name", ["a.vtu", "a.vtk"])
def test_regions_go_by_labels_of_files_that_meshio_writes(tmp_path, name):
    """Checked by mass: a cube of five tets, of which the middle one has a third of the volume."""
    meshio = pytest.importorskip("meshio")
    points, tets = palpate.box((1, 1, 1), (1.0, 1.0, 1.0))
    volumes = np.abs(np.linalg.det(points[tets[:, 1:]] - points[tets[:, :1]])) / 6
    labels = np.where(volumes > 0.3, 4, 9)
    meshio.write(tmp_path / name, meshio.Mesh(points, [("tetra", tets)], cell_data={"label": [labels], "two": [np.ones((5, 2))]}))
    body = {"mesh": str(tmp_path / name), "material": {"density": 3}, "regions": [{"label": 4, "material": {"density": 30}}]}
    assert palpate.Simulation({"bodies": [body]}).masses[0] == pytest.approx(2 / 3 * 3 + 1 / 3 * 30)
    body["regions"][0]["label"] = 5
    with pytest.raises(palpate.Error, match="label: found 5, expected a label of its tets: 4, 9"):
        palpate.Simulation({"bodies": [body]})


@pytest.mark.parametrize(("elements", "active"), [("linear", 0.0), ("smoothed", 0.3)])
def test_a_bar_that_is_squeezed_converges(elements, active):
    """Tangents of compressed tissue lack negative eigenvalues, so updates shrink slowly: without extrapolation, 10 and 6
    of these 30 steps did not converge after 280 solves, and steps made 115 and 96 on average."""
    fibres = {"direction": [1, 0.3, 0.1], "stiffness": 2e3, "exponent": 1, "active_stress": active * 2e4}
    bar = {
        "name": "bar",
        "box": {"cells": [10, 4, 4], "size": [0.05, 0.016, 0.016]},
        "material": {"young_modulus": 2e4, "poisson_ratio": 0.45, "model": "stable-neo-hookean", "elements": elements,
                     "fibres": fibres | {"activation": {"times": [0, 0.1], "factors": [0, 1]}}},
        "fixed": [{"box": {"lower": [-0.02501, -1, -1], "upper": [-0.02499, 1, 1]}}],
    }
    plates = [
        {"name": name, "box": {"cells": [3, 3, 1], "size": [0.02, 0.03, 0.006]}, "translate": [0, 0, sign * 0.0115],
         "motion": {"keyframes": [{"time": 0.05}, {"time": 0.25, "translate": [0, 0, -sign * 0.005]}]}}
        for name, sign in (("upper", 1), ("lower", -1))]
    scene = {"time_step": 0.01, "gravity": [0, 0, 0], "contact": {"friction": 0.3}, "bodies": [bar, *plates]}
    simulation = palpate.Simulation(scene, threads=1)
    solves = 0
    for _ in range(30):
        simulation.step()
        solves += simulation.metrics.solves
    assert simulation.steps_not_converged == 0
    assert solves < 30 * 60
