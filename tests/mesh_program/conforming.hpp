#pragma once

#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <palpate/io/mesh_reader.hpp>

#include "geometry/vector.hpp"
#include "mesh_program/meshed.hpp"

namespace palpate::test {

/// A triangle by its corners, rotated so that the least is first: the same bits for the same triangle.
using PlacedTriangle = std::array<std::array<double, 3>, 3>;

/// The surface of a mesh: triangles with one tet, counter-clockwise from outside.
std::set<PlacedTriangle> surface_of(const TetMesh& mesh);
/// The triangle seen from the other side.
PlacedTriangle turned(const PlacedTriangle& triangle);

/// A test of `palpate mesh --conforming`.
class Conforming : public MeshProgram {
 protected:
  Json conforming(const std::string& input, std::vector<std::string> flags) const {
    flags.emplace_back("--conforming");
    return meshed(input, std::move(flags));
  }
  [[nodiscard]] TetMesh mesh(const std::string& name) const {
    return io::read_mesh(folder_ / ("out/" + name + ".vtu")).mesh;
  }
};

}  // namespace palpate::test
