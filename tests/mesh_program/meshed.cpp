#include "mesh_program/meshed.hpp"

#include <algorithm>
#include <set>

#include <palpate/io/mesh_reader.hpp>

namespace palpate::test {

long MeshProgram::euler_characteristic(const std::string& organ) const {
  Bodies bodies;
  bodies.add(organ, io::read_mesh(folder_ / ("out/" + organ + ".vtu")).mesh);
  std::set<Index> points;
  std::set<std::pair<Index, Index>> edges;
  for (const Triangle& t : bodies.triangles()) {
    points.insert(t.begin(), t.end());
    for (std::size_t c = 0; c < 3; ++c) edges.insert(std::minmax(t[c], t[(c + 1) % 3]));
  }
  return static_cast<long>(points.size()) - static_cast<long>(edges.size()) +
         static_cast<long>(bodies.triangles().size());
}

void MeshProgram::write_series(const std::string& name, const TestMap& map,
                               const std::string& object_class) const {
  std::filesystem::create_directory(folder_ / name);
  for (int k = 0; k < map.size[2]; ++k) {
    put(folder_ / (name + "/" + std::to_string(k) + ".dcm"), dicom_slice(map, k, object_class));
  }
}

void expect_volume(const Json& info, double volume) {
  EXPECT_NEAR(info["volume"].get<double>(), volume, 0.02 * volume);
}

void expect_box(const Json& info, const Vec3& lower, const Vec3& upper, double within) {
  const auto expect = [&](const Json& found, const Vec3& wanted) {
    EXPECT_NEAR(found[0].get<double>(), wanted.x, within);
    EXPECT_NEAR(found[1].get<double>(), wanted.y, within);
    EXPECT_NEAR(found[2].get<double>(), wanted.z, within);
  };
  expect(info["lower"], lower);
  expect(info["upper"], upper);
}

}  // namespace palpate::test
