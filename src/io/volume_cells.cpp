#include "io/volume_cells.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "geometry/vector.hpp"

namespace palpate::io {
namespace {

using Face = std::array<std::size_t, 4>;
constexpr std::size_t none = 8;  // instead of the fourth corner of a triangle

struct Shape {
  std::string_view name;
  std::size_t corners;
  std::array<Face, 6> faces;
  std::size_t face_count;
};

// vtkHexahedron, vtkWedge and vtkPyramid of VTK 9, their orientation does not matter here.
constexpr std::array<Shape, 4> shapes{
    {{"tetrahedron", 4, {}, 0},
     {"hexahedron",
      8,
      {{{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}},
      6},
     {"wedge", 6, {{{0, 1, 2, none}, {3, 5, 4, none}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}, {}}}, 5},
     {"pyramid",
      5,
      {{{0, 3, 2, 1}, {0, 1, 4, none}, {1, 2, 4, none}, {2, 3, 4, none}, {3, 0, 4, none}, {}}},
      5}}};

const Shape* shape_of(std::string_view kind) {
  const auto found = std::ranges::find_if(
      shapes, [&](const Shape& shape) { return kind.find(shape.name) != std::string_view::npos; });
  return found == shapes.end() ? nullptr : &*found;
}

/// Appends tets to a mesh; those with a corner twice have no volume and are left out.
class TetAppender {
 public:
  explicit TetAppender(TetMesh& mesh) : mesh_(mesh) {}

  void append(Tet tet) {
    for (std::size_t i = 0; i < tet.size(); ++i) {
      for (std::size_t j = i + 1; j < tet.size(); ++j) {
        if (tet[i] == tet[j]) return;
      }
    }
    const Vec3& a = at(mesh_.points, tet[0]);
    const double volume =
        dot(at(mesh_.points, tet[1]) - a, cross(at(mesh_.points, tet[2]) - a, at(mesh_.points, tet[3]) - a));
    if (volume < 0.0) std::swap(tet[2], tet[3]);
    mesh_.tets.push_back(tet);
  }

  /// Appends the tets between a face of the cell and the cell's lowest corner, which is not on that face.
  void append_face(std::span<const Index> face, Index lowest) {
    const auto first = static_cast<std::size_t>(std::ranges::min_element(face) - face.begin());
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      append({face[first], face[(first + i) % face.size()], face[(first + i + 1) % face.size()], lowest});
    }
  }

 private:
  TetMesh& mesh_;
};

void cut(const Shape& shape, std::span<const Index> corners, TetMesh& mesh) {
  const Index lowest = *std::ranges::min_element(corners);
  TetAppender appender(mesh);
  for (std::size_t f = 0; f < shape.face_count; ++f) {
    std::array<Index, 4> face{};
    std::size_t size = 0;
    for (const std::size_t corner : shape.faces[f]) {
      if (corner != none) face[size++] = corners[corner];
    }
    const std::span<const Index> used(face.data(), size);
    if (std::ranges::count(used, lowest) == 0) appender.append_face(used, lowest);
  }
}

ConvertedCells& entry_of(MeshFile& file, std::string_view kind) {
  const auto known = std::ranges::find(file.converted, kind, &ConvertedCells::kind);
  if (known != file.converted.end()) return *known;
  return file.converted.emplace_back(ConvertedCells{std::string(kind), 0, 0});
}

}  // namespace

std::size_t volume_corners(std::string_view kind) {
  const Shape* shape = shape_of(kind);
  return shape == nullptr ? 0 : shape->corners;
}

void add_volume_cell(MeshFile& file, std::string_view kind, std::span<const Index> corners) {
  const Shape& shape = *shape_of(kind);
  if (kind == "tetrahedron") {
    file.mesh.tets.push_back({corners[0], corners[1], corners[2], corners[3]});
    return;
  }
  const std::size_t before = file.mesh.tets.size();
  if (shape.face_count == 0) {
    file.mesh.tets.push_back({corners[0], corners[1], corners[2], corners[3]});
  } else {
    cut(shape, corners.first(shape.corners), file.mesh);
  }
  ConvertedCells& entry = entry_of(file, kind);
  ++entry.cells;
  entry.tets += static_cast<Index>(file.mesh.tets.size() - before);
}

}  // namespace palpate::io
