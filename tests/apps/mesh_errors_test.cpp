#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

/// Every kind of mesh that must be refused, through `info` and through `run` of a scene that names the mesh.
class MeshErrors : public CommandTest {
 protected:
  void expect_refused(const std::string& name, const std::vector<std::string>& parts) const {
    std::vector<std::string> all{name};
    all.insert(all.end(), parts.begin(), parts.end());
    expect_error(2, {"info", name}, all);
    write("scene.json", R"({"bodies": [{"mesh": ")" + name + R"(", "material": {}}]})");
    expect_error(2, {"run", "scene.json"}, all);
    expect_error(2, {"detect", "scene.json"}, all);
    expect_error(2, {"info", "scene.json"}, all);
    EXPECT_FALSE(exists("results"));
  }
};

std::string medit(const std::string& tet, const std::string& last_point = "0 0 1 0") {
  return "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n" + last_point +
         "\nTetrahedra\n1\n" + tet + "\nEnd\n";
}

TEST_F(MeshErrors, Missing) {
  expect_refused("missing.vtu", {"no such file"});
}

TEST_F(MeshErrors, Truncated) {
  write("cut.mesh", medit("1 2 3 4 0").substr(0, 80));
  expect_refused("cut.mesh", {"line"});
  output_of({"generate", "ball", "--resolution", "3", "--out", "whole.vtu"});
  const std::string whole = read("whole.vtu");
  write("cut.vtu", whole.substr(0, whole.size() * 2 / 3));
  expect_refused("cut.vtu", {});
}

TEST_F(MeshErrors, Corrupt) {
  write("noise.msh", std::string("\x7f\x45\x4c\x46\x02\0\0\0\xff\xfe", 10));
  expect_refused("noise.msh", {"found"});
  write("noise.vtu", "this is no XML");
  expect_refused("noise.vtu", {"found"});
}

TEST_F(MeshErrors, IndexOutOfRange) {
  write("range.mesh", medit("1 2 3 5 0"));
  expect_refused("range.mesh", {"5"});
}

TEST_F(MeshErrors, RepeatedPoint) {
  write("twice.mesh", medit("1 2 3 3 0"));
  expect_refused("twice.mesh", {"tet 0", "point 2 twice", "four different points"});
}

TEST_F(MeshErrors, ZeroVolume) {
  write("flat.mesh", medit("1 2 3 4 0", "1 1 0 0"));
  expect_refused("flat.mesh", {"tet 0", "volume"});
}

TEST_F(MeshErrors, NotFinite) {
  write("nan.mesh", medit("1 2 3 4 0", "0 0 nan 0"));
  expect_refused("nan.mesh", {"nan"});
  write("inf.mesh", medit("1 2 3 4 0", "0 0 inf 0"));
  expect_refused("inf.mesh", {"inf"});
}

TEST_F(MeshErrors, Empty) {
  write("empty.msh", "");
  expect_refused("empty.msh", {"found"});
  write("empty.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices\n0\nTetrahedra\n0\nEnd\n");
  expect_refused("empty.mesh", {"found"});
}

TEST_F(MeshErrors, SurfaceOnly) {
  write("surface.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n0 1 0 0\nTriangles\n1\n1 2 3 "
        "0\nEnd\n");
  expect_refused("surface.mesh", {"triangle", "tet"});
}

TEST_F(MeshErrors, UnknownFormat) {
  write("body.stl", "solid");
  expect_refused("body.stl", {".stl"});
}

}  // namespace
}  // namespace palpate::test
