"""Mesh files against meshio and VTK, grids for pictures, and errors of bad files."""

import numpy as np
import pytest

import meshio
import palpate
import pyvista


def in_order(points, tets):
    """Corner positions of each tet, in an order that does not depend on the numbering or order of corners."""
    corners = points[tets]
    return np.array(sorted(sorted(map(tuple, tet)) for tet in corners.tolist()))


@pytest.mark.parametrize("extension", ["vtu", "vtk", "msh", "mesh", "inp"])
def test_meshes_written_by_meshio_come_back(tmp_path, extension):
    points, tets = palpate.ball(0.5, 3)
    file = tmp_path / f"ball.{extension}"
    palpate.write_mesh(file, points, tets, point_data={"height": points[:, 2]}, cell_data={"number": np.arange(540)})
    again, corners = palpate.read_mesh(file)
    np.testing.assert_allclose(in_order(again, corners), in_order(points, tets), rtol=1e-9, atol=1e-12)


def hexahedra_of(cells):
    """A lattice of unit cubes: points and hexahedra in the order of VTK."""
    sides = np.array(cells) + 1
    points = np.stack(np.meshgrid(*map(np.arange, sides), indexing="ij"), -1).reshape(-1, 3).astype(float)
    def number(i, j, k):
        return (i * sides[1] + j) * sides[2] + k
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    return points, np.array([[number(i + a, j + b, k + c) for a, b, c in corners]
                             for i in range(cells[0]) for j in range(cells[1]) for k in range(cells[2])])


def volume_of(points, tets):
    a, b, c, d = (points[tets[:, corner]] for corner in range(4))
    return np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)).sum() / 6


@pytest.mark.parametrize("extension", ["inp", "xdmf", "vtu", "vtk", "msh"])
def test_hexahedra_of_meshio_are_cut(tmp_path, extension):
    points, hexahedra = hexahedra_of((3, 2, 2))
    file = tmp_path / f"cubes.{extension}"
    if extension == "xdmf":  # by hand: meshio's writer needs h5py
        def item(values):
            return f'<DataItem DataType="{"Int" if values.dtype.kind == "i" else "Float"}" Dimensions="{len(values)} ' \
                   f'{values.shape[1]}" Format="XML">{" ".join(map(str, values.ravel()))}</DataItem>'
        file.write_text(f'<Xdmf Version="3.0"><Domain><Grid Name="Grid"><Geometry GeometryType="XYZ">{item(points)}'
                        f'</Geometry><Topology TopologyType="Hexahedron" NumberOfElements="12">{item(hexahedra)}'
                        '</Topology></Grid></Domain></Xdmf>')
    else:
        meshio.write(file, meshio.Mesh(points, [("hexahedron", hexahedra)]),
                     file_format="gmsh" if extension == "msh" else None)
    again, tets = palpate.read_mesh(file)
    assert len(tets) == 6 * 12
    assert volume_of(again, tets) == pytest.approx(12.0)
    faces = np.sort(np.concatenate([tets[:, list(f)] for f in [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]]), axis=1)
    counts = np.unique(faces, axis=0, return_counts=True)[1]
    assert (counts == 1).sum() == 64  # two triangles on each unit square of the surface: inner faces match


def test_quadratic_tets_of_meshio_are_taken_as_linear(tmp_path):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    middles = np.array([corners[a] + corners[b] for a, b in [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]]) / 2
    meshio.write(tmp_path / "ten.inp", meshio.Mesh(np.vstack([corners, middles]), [("tetra10", [list(range(10))])]))
    points, tets = palpate.read_mesh(tmp_path / "ten.inp")
    assert tets.tolist() == [[0, 1, 2, 3]] and volume_of(points, tets) == pytest.approx(1 / 6)


@pytest.mark.parametrize("compression", ["none", "zlib", "lz4", "lzma"])
def test_compressed_files_of_vtk(tmp_path, compression):
    """VTK writes with each of its compressors. We read zlib, and meshio LZMA; LZ4 is an error."""
    points, tets = palpate.box((6, 6, 6), (1, 1, 1))
    writer = pyvista._vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(palpate.to_pyvista(points, tets))
    file = tmp_path / "box.vtu"
    writer.SetFileName(str(file))
    writer.SetCompressorType({"none": 0, "zlib": 1, "lz4": 2, "lzma": 3}[compression])
    assert writer.Write()
    if compression == "lz4":  # read by neither us nor meshio
        with pytest.raises(palpate.Error, match="box.vtu"):
            palpate.read_mesh(file)
        return
    again, corners = palpate.read_mesh(file)
    assert np.array_equal(in_order(again, corners), in_order(points, tets))


def test_damaged_zlib_is_refused(tmp_path):
    points, tets = palpate.box((6, 6, 6), (1, 1, 1))
    writer = pyvista._vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(palpate.to_pyvista(points, tets))
    writer.SetFileName(str(tmp_path / "box.vtu"))
    writer.SetDataModeToAppended()
    writer.EncodeAppendedDataOff()
    writer.SetCompressorTypeToZLib()
    writer.Write()
    data = bytearray((tmp_path / "box.vtu").read_bytes())
    start = data.index(b"<AppendedData") + 200
    for place in range(start, start + 400):
        data[place] ^= 0x55
    (tmp_path / "bad.vtu").write_bytes(data)
    with pytest.raises(palpate.Error, match="bad.vtu"):
        palpate.read_mesh(tmp_path / "bad.vtu")


def test_bad_mesh_files_are_refused(tmp_path):
    (tmp_path / "text.msh").write_text("nonsense")
    (tmp_path / "text.inp").write_text("nonsense")
    meshio.write(tmp_path / "flat.inp", meshio.Mesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [("triangle", [[0, 1, 2]])]))
    for name in ["text.msh", "text.inp", "none.msh", "none.inp", "none.what", "flat.inp", "box"]:
        with pytest.raises(palpate.Error, match=name):
            palpate.read_mesh(tmp_path / name)
    with pytest.raises(palpate.Error, match="what.what"):
        palpate.write_mesh(tmp_path / "what.what", *palpate.box((1, 1, 1), (1, 1, 1)))


def test_bad_meshes_are_not_written(tmp_path):
    points, tets = palpate.box((2, 2, 2), (0.1, 0.1, 0.1))
    holed = points.copy()
    holed[7, 1] = np.nan
    file = tmp_path / "box.vtu"
    for mesh, message in [((points, tets + 1000), "tet 0.*1000.*0 to 26"), ((points, tets - 5), "tet 0"),
                          ((holed, tets), "point 7.*nan.*finite"), ((points, tets[:0]), "no tets")]:
        with pytest.raises(palpate.Error, match=message):
            palpate.write_mesh(file, *mesh)
    with pytest.raises(palpate.Error, match=r"point_data\['height'\].*27 rows"):
        palpate.write_mesh(file, points, tets, point_data={"height": points[1:, 2]})
    with pytest.raises(palpate.Error, match=r"cell_data\['label'\].*40 rows"):
        palpate.write_mesh(file, points, tets, cell_data={"label": 3})
    assert not file.exists()
    palpate.write_mesh(file, points, tets[:, [1, 0, 2, 3]])  # a result may have inverted tets
    assert len(meshio.read(file).cells[0].data) == 40


def test_generators_check_their_arguments():
    points, tets = palpate.box((2, 3, 4), (0.2, 0.3, 0.4))
    assert points.shape == (60, 3) and tets.shape == (120, 4)
    np.testing.assert_allclose([points.min(0), points.max(0)], [[-0.1, -0.15, -0.2], [0.1, 0.15, 0.2]])
    assert palpate.ball(1.0, 4)[1].shape == (20 * 64, 4)
    for call in [lambda: palpate.box((0, 1, 1), (1, 1, 1)), lambda: palpate.box((1, 1, 1), (1, 1)),
                 lambda: palpate.box((1, 1, 1), (1, 1, np.inf)), lambda: palpate.ball(-1.0, 2),
                 lambda: palpate.ball(1.0, 0)]:
        with pytest.raises(palpate.Error):
            call()


def test_grids_of_pyvista():
    points, tets = palpate.box((4, 4, 4), (1, 1, 1))
    grid = palpate.to_pyvista(points, tets)
    assert grid.volume == pytest.approx(1.0)
    world = palpate.World()
    world.add(points, tets)
    world.add(points, tets)
    positions = np.concatenate([points, points + [0, 0, 0.9]])
    world.update(positions)
    grid = world.to_pyvista(positions)
    assert grid.n_points == 250 and grid.n_cells == 640
    assert grid.point_data["depth"].max() == world.contacts.depth.max()
    assert (grid.cell_data["body"][:320] == 0).all() and (grid.cell_data["body"][320:] == 1).all()
    simulation = palpate.Simulation(palpate.stacking_scene(count=2, cells=(2, 2, 1)))
    simulation.run(2)
    assert np.array_equal(simulation.to_pyvista().point_data["velocity"], simulation.velocities)
    with pytest.raises(palpate.Error, match="give points.T"):
        palpate.to_pyvista(points.T, tets)
    with pytest.raises(palpate.Error, match="tets"):
        palpate.to_pyvista(points, tets + 1)
    with pytest.raises(palpate.Error, match="125 points"):
        world.to_pyvista(points)


def test_scenes_as_mappings(tmp_path, root):
    scene = palpate.read_scene(root / "scenes/ball-on-plate.json")
    palpate.write_scene(scene, tmp_path / "again.json")
    assert palpate.read_scene(tmp_path / "again.json") == scene
    assert len(palpate.stacking_scene(count=3)["bodies"]) == 3
    scene["bodies"][0]["color"] = "red"
    with pytest.raises(palpate.Error, match="color"):
        palpate.write_scene(scene, tmp_path / "bad.json")
    assert not (tmp_path / "bad.json").exists()
    for what in [{"bodies": [object()]}, {"bodies": [], "gravity": [0, 0, float("inf")]}, {}]:
        with pytest.raises(palpate.Error):
            palpate.Simulation(what)


def test_paths_of_meshes_become_absolute(tmp_path):
    palpate.write_mesh(tmp_path / "ball.vtu", *palpate.ball(0.1, 2))
    (tmp_path / "scene.json").write_text('{"bodies": [{"mesh": "ball.vtu", "material": {}}]}')
    scene = palpate.read_scene(tmp_path / "scene.json")
    assert scene["bodies"][0]["mesh"] == str(tmp_path / "ball.vtu")
    assert palpate.Simulation(scene).positions.shape == palpate.Simulation(tmp_path / "scene.json").positions.shape


def test_threads_setting():
    assert palpate.get_threads() == 0
    try:
        palpate.set_threads(2)
        assert palpate.get_threads() == 2
    finally:
        palpate.set_threads(0)
    for wrong in [-1, 5000, 1.5, "2", True, None]:
        with pytest.raises(palpate.Error):
            palpate.set_threads(wrong)
