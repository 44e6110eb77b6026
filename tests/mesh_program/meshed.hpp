#pragma once

#include <string>

#include "apps/workplace.hpp"
#include "mesh_program/maps.hpp"

namespace palpate::test {

/// A test of `palpate mesh` in a temporary folder.
class MeshProgram : public CommandTest {
 protected:
  /// Meshes `input` into the folder "out" and returns the report.
  [[nodiscard]] Json meshed(const std::string& input, std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"mesh", input, "--out", "out", "--replace", "--json", "--quiet"});
    const Finished finished = palpate(std::move(flags));
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return finished.exit_code == 0 ? Json::parse(finished.out) : Json();
  }
  /// Writes a folder with a DICOM series.
  void write_series(const std::string& name, const TestMap& map, const std::string& object_class) const;
  /// The report of `palpate info` about a mesh in "out".
  [[nodiscard]] Json info(const std::string& organ) const {
    return json_of({"info", "out/" + organ + ".vtu", "--json"});
  }
  /// Euler characteristic of the surface of a mesh in "out": 2 for each ball, 0 for a torus.
  [[nodiscard]] long euler_characteristic(const std::string& organ) const;
};

/// Expects volume within 2 %, as the issue asks.
void expect_volume(const Json& info, double volume);
/// Expects the bounding box of a mesh within a tolerance.
void expect_box(const Json& info, const Vec3& lower, const Vec3& upper, double within);

}  // namespace palpate::test
