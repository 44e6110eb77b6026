// Cells that are no four-point tets; oracles: volumes worked out by hand, and VTK as writer of cell types.
#include <array>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <vector>
#include <vtkCellType.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>

#include <palpate/mesh.hpp>

#include "io/mesh_files.hpp"

namespace palpate::io::testing {
namespace {

using Converted = std::vector<std::tuple<std::string, Index, Index>>;

Converted converted(const MeshFile& file) {
  Converted list;
  for (const ConvertedCells& cells : file.converted) list.emplace_back(cells.kind, cells.cells, cells.tets);
  return list;
}

/// Volume and surface of the whole, which are right only for a conforming mesh. Throws if a face has three
/// tets.
MeshStatistics statistics_of(const MeshFile& file) {
  Bodies bodies;
  bodies.add("mesh", file.mesh);
  EXPECT_EQ(bodies.notes()[0].reoriented_tets, 0);
  return mesh_statistics(bodies, bodies.points_rest());
}

/// A lattice of 3 x 2 x 2 unit cubes with its points numbered in a scrambled order, so that every diagonal
/// occurs.
struct Cubes {
  std::array<int, 3> cells{3, 2, 2};
  [[nodiscard]] int points() const { return (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1); }
  [[nodiscard]] int number(int i, int j, int k) const {
    return (((k * (cells[1] + 1) + j) * (cells[0] + 1) + i) * 17 + 5) %
           points();  // 17 and 36 have no common factor
  }
  [[nodiscard]] std::array<double, 3> place(int number) const {
    for (int k = 0; k <= cells[2]; ++k)
      for (int j = 0; j <= cells[1]; ++j)
        for (int i = 0; i <= cells[0]; ++i)
          if (this->number(i, j, k) == number) return {double(i), double(j), double(k)};
    return {};
  }
  /// Corners in VTK's order.
  [[nodiscard]] std::array<int, 8> corners(int i, int j, int k) const {
    return {
        number(i, j, k),     number(i + 1, j, k),     number(i + 1, j + 1, k),     number(i, j + 1, k),
        number(i, j, k + 1), number(i + 1, j, k + 1), number(i + 1, j + 1, k + 1), number(i, j + 1, k + 1)};
  }
  template <class Function>
  void for_cells(Function&& f) const {
    for (int k = 0; k < cells[2]; ++k)
      for (int j = 0; j < cells[1]; ++j)
        for (int i = 0; i < cells[0]; ++i) f(corners(i, j, k));
  }
};

/// Medit, every fifth cube as six pyramids round its middle.
std::string cubes_in_medit(const Cubes& cubes) {
  std::string hexahedra, pyramids, middles;
  int counts[2] = {0, 0};
  int cell = 0, extra = cubes.points();
  const auto add = [](std::string& text, int& count, std::initializer_list<int> corners) {
    for (const int c : corners) text += std::to_string(c + 1) + " ";
    text += "0\n";
    ++count;
  };
  cubes.for_cells([&](const std::array<int, 8>& c) {
    if (cell % 5 == 4) {
      Vec3 middle;
      for (const int corner : c) {
        const auto p = cubes.place(corner);
        middle = {middle.x + p[0] / 8, middle.y + p[1] / 8, middle.z + p[2] / 8};
      }
      middles +=
          std::to_string(middle.x) + " " + std::to_string(middle.y) + " " + std::to_string(middle.z) + " 0\n";
      const int faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                               {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
      for (const auto& f : faces) add(pyramids, counts[1], {c[f[0]], c[f[1]], c[f[2]], c[f[3]], extra});
      ++extra;
    } else {
      add(hexahedra, counts[0], {c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]});
    }
    ++cell;
  });
  std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices\n" + std::to_string(extra) + "\n";
  for (int p = 0; p < cubes.points(); ++p) {
    const auto place = cubes.place(p);
    for (const double x : place) text += std::to_string(x) + " ";
    text += "0\n";
  }
  text += middles + "Hexahedra\n" + std::to_string(counts[0]) + "\n" + hexahedra;
  text += "Pyramids\n" + std::to_string(counts[1]) + "\n" + pyramids + "End\n";
  return text;
}

TEST(CellKinds, HexahedraAndPyramidsAreCutSoThatFacesMatch) {
  const Folder folder;
  const Cubes cubes;
  const MeshFile file = read_mesh(folder.write("cubes.mesh", cubes_in_medit(cubes)));
  EXPECT_EQ(converted(file), (Converted{{"hexahedron", 10, 60}, {"pyramid", 12, 24}}));
  EXPECT_TRUE(file.dropped.empty());
  const MeshStatistics statistics = statistics_of(file);
  EXPECT_NEAR(statistics.volume, 12.0, 1e-12);
  // 2 (3*2 + 3*2 + 2*2) unit squares, two triangles each: where faces did not match there would be more.
  EXPECT_EQ(statistics.triangles, 64);
}

TEST(CellKinds, WedgesAndHexahedraThatShareQuadsAreCutAlike) {
  // A cube beside a wedge on its square side, for each rotation of the point numbers.
  const std::vector<std::array<double, 3>> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},   {0, 0, 1},
                                                  {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {2, 0.5, 0}, {2, 0.5, 1}};
  const Folder folder;
  for (int shift = 0; shift < 10; ++shift) {
    const auto number = [&](int p) { return std::to_string((p + shift) % 10 + 1) + " "; };
    std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices\n10\n";
    for (int p = 0; p < 10; ++p) {
      for (const double x : points[static_cast<std::size_t>((p + 10 - shift) % 10)])
        text += std::to_string(x) + " ";
      text += "0\n";
    }
    text += "Hexahedra\n1\n";
    for (const int p : {0, 1, 2, 3, 4, 5, 6, 7}) text += number(p);
    text += "0\nPrisms\n1\n";
    for (const int p : {1, 8, 2, 5, 9, 6}) text += number(p);
    text += "0\nEnd\n";
    const MeshFile file = read_mesh(folder.write("pair.mesh", text));
    EXPECT_EQ(converted(file), (Converted{{"hexahedron", 1, 6}, {"wedge", 1, 3}})) << shift;
    const MeshStatistics statistics = statistics_of(file);
    EXPECT_NEAR(statistics.volume, 1.5, 1e-12) << shift;
    EXPECT_EQ(statistics.triangles, 10 + 6)
        << "five squares of the cube; of the wedge two squares, two triangles";
  }
}

TEST(CellKinds, ACollapsedHexahedronIsAWedge) {
  const Folder folder;
  const MeshFile file = read_mesh(folder.write("wedge.mesh",
                                               "MeshVersionFormatted 2\nDimension 3\nVertices\n6\n0 0 0 0\n1 "
                                               "0 0 0\n0 1 0 0\n0 0 2 0\n1 0 2 0\n0 1 2 0\n"
                                               "Hexahedra\n1\n1 2 3 3 4 5 6 6 0\nEnd\n"));
  EXPECT_EQ(converted(file), (Converted{{"hexahedron", 1, 3}}));
  EXPECT_NEAR(statistics_of(file).volume, 1.0, 1e-15);
}

/// Each volume cell type of VTK, linear and quadratic, on the unit cube or a part of it.
TEST(CellKinds, TypesOfVtkHaveTheVolumeOfTheirCorners) {
  struct Case {
    int type;
    std::vector<int> corners;  ///< of the unit cube, VTK's order; 8 is (0.5, 0.5, 1)
    int nodes;
    double volume;
    Converted converted;
  };
  const std::vector<int> cube{0, 1, 2, 3, 4, 5, 6, 7};
  const std::vector<int> lattice{0, 1, 3, 2, 4, 5, 7, 6};
  const std::vector<Case> cases{
      {VTK_VOXEL, lattice, 8, 1.0, {{"hexahedron", 1, 6}}},
      {VTK_HEXAHEDRON, cube, 8, 1.0, {{"hexahedron", 1, 6}}},
      {VTK_QUADRATIC_HEXAHEDRON, cube, 20, 1.0, {{"hexahedron20", 1, 6}}},
      {VTK_TRIQUADRATIC_HEXAHEDRON, cube, 27, 1.0, {{"hexahedron27", 1, 6}}},
      {VTK_WEDGE, {0, 1, 3, 4, 5, 7}, 6, 0.5, {{"wedge", 1, 3}}},
      {VTK_QUADRATIC_WEDGE, {0, 1, 3, 4, 5, 7}, 15, 0.5, {{"wedge15", 1, 3}}},
      {VTK_PYRAMID, {0, 1, 2, 3, 8}, 5, 1.0 / 3.0, {{"pyramid", 1, 2}}},
      {VTK_QUADRATIC_PYRAMID, {0, 1, 2, 3, 8}, 13, 1.0 / 3.0, {{"pyramid13", 1, 2}}},
      {VTK_QUADRATIC_TETRA, {0, 1, 3, 4}, 10, 1.0 / 6.0, {{"tetrahedron10", 1, 1}}}};
  const Folder folder;
  for (const Case& c : cases) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    const double places[9][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},    {0, 0, 1},
                                 {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0.5, 0.5, 1}};
    for (const auto& p : places) points->InsertNextPoint(p);
    std::vector<vtkIdType> nodes(c.corners.begin(), c.corners.end());
    while (static_cast<int>(nodes.size()) < c.nodes)  // middle points, bent outwards
      nodes.push_back(points->InsertNextPoint(0.5, 0.5, 3.0 + static_cast<double>(nodes.size())));
    vtkNew<vtkUnstructuredGrid> grid;
    grid->SetPoints(points);
    grid->InsertNextCell(c.type, static_cast<vtkIdType>(nodes.size()), nodes.data());
    const std::string path = folder.path() / "cell.vtk";
    vtkNew<vtkUnstructuredGridWriter> writer;
    writer->SetInputData(grid);
    writer->SetFileName(path.c_str());
    ASSERT_EQ(writer->Write(), 1);
    SCOPED_TRACE("VTK cell type " + std::to_string(c.type));
    const MeshFile file = read_mesh(path);
    EXPECT_EQ(converted(file), c.converted);
    EXPECT_NEAR(statistics_of(file).volume, c.volume, 1e-15);
  }
}

TEST(CellKinds, QuadraticTetsOfTetGenAndGmshAreTakenAsLinear) {
  const Folder folder;
  std::string node = "10 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  std::string ele = "1 10 0\n1 1 2 3 4";
  std::string msh = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  std::string element = "1 11 0 1 2 3 4";
  for (int p = 5; p <= 10; ++p) {
    const std::string line = std::to_string(p) + " 0.5 0.5 " + std::to_string(p) + "\n";
    node += line;
    msh += line;
    ele += std::string(" ").append(std::to_string(p));
    element += std::string(" ").append(std::to_string(p));
  }
  ASSERT_FALSE(folder.write("ten.node", node).empty());
  const auto tetgen = folder.write("ten.ele", ele + "\n");
  const auto gmsh = folder.write("ten.msh", msh + "$EndNodes\n$Elements\n1\n" + element + "\n$EndElements\n");
  for (const auto& path : {tetgen, gmsh}) {
    const MeshFile file = read_mesh(path);
    EXPECT_EQ(converted(file), (Converted{{"tetrahedron10", 1, 1}}));
    EXPECT_EQ(file.mesh.points.size(), 10U);
    EXPECT_EQ(file.mesh.tets, (std::vector<Tet>{{0, 1, 2, 3}}));
    const MeshStatistics statistics = statistics_of(file);
    EXPECT_NEAR(statistics.volume, 1.0 / 6.0, 1e-15);
    EXPECT_EQ(statistics.upper, (Vec3{1, 1, 1})) << "middle points are out of the bounds";
  }
}

TEST(CellKinds, BadCornersAreNamed) {
  const Folder folder;
  const std::string head =
      "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
  EXPECT_EQ(error_of(folder.write("a.mesh", head + "Prisms\n1\n1 2 3 4 1 9 0\nEnd\n")),
            "a.mesh: line 11: found point number 9, expected one from 1 to 4");
  EXPECT_EQ(error_of(folder.write("a.mesh", head + "Hexahedra\n1\n1 1 1 1 1 1 1 1 0\nEnd\n")),
            "a.mesh: found no cells, expected at least one tet");
  const std::string vtk =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 "
      "0 1\n"
      "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n71\n";
  EXPECT_EQ(error_of(folder.write("a.vtk", vtk)),
            "a.vtk: cell 0: found 3 corners, expected at least 4 for a Lagrange tetrahedron (cell type 71)");
}

}  // namespace
}  // namespace palpate::io::testing
