// Surfaces as VTK writes them; oracle: VTK, whose writers share no code with our readers.
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkOBJWriter.h>
#include <vtkPLYWriter.h>
#include <vtkPolyData.h>
#include <vtkPolyDataWriter.h>
#include <vtkSTLWriter.h>
#include <vtkSphereSource.h>
#include <vtkStripper.h>
#include <vtkXMLPolyDataWriter.h>

#include "mesh_program/meshed.hpp"

namespace palpate::test {
namespace {

class Surfaces : public MeshProgram {
 protected:
  void SetUp() override {
    sphere_->SetRadius(10.0);
    sphere_->SetThetaResolution(20);
    sphere_->SetPhiResolution(12);
  }
  template <class Writer, class Settings>
  std::string written(const std::string& name, Settings&& settings) {
    vtkNew<Writer> writer;
    writer->SetFileName((folder_ / name).c_str());
    writer->SetInputConnection(sphere_->GetOutputPort());
    settings(*writer);
    writer->Write();
    return name;
  }
  template <class Writer>
  std::string written(const std::string& name) {
    return written<Writer>(name, [](Writer&) {});
  }
  /// The mesh of the organ in such a file.
  std::string mesh_of(const std::string& name) {
    std::filesystem::remove_all(folder_ / "out");
    const Finished done = palpate({"mesh", name, "--out", "out", "--size", "4", "--quiet"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    return read("out/" + std::filesystem::path(name).stem().string() + ".vtu");
  }

  /// The sphere as OFF, written here: VTK has no writer for it.
  std::string off_of_sphere() {
    sphere_->Update();
    vtkPolyData* data = sphere_->GetOutput();
    std::string text = "OFF\n" + std::to_string(data->GetNumberOfPoints()) + " " +
                       std::to_string(data->GetNumberOfPolys()) + " 0\n";
    for (vtkIdType p = 0; p < data->GetNumberOfPoints(); ++p) {
      for (int a = 0; a < 3; ++a) text += number(data->GetPoint(p)[a]) + " ";
      text += "\n";
    }
    for (vtkIdType t = 0; t < data->GetNumberOfPolys(); ++t) {
      text += "3";
      for (int c = 0; c < 3; ++c)
        text += std::string(" ").append(std::to_string(data->GetCell(t)->GetPointId(c)));
      text += "\n";
    }
    return text;
  }
  /// A number with all digits, so that it is read back exactly.
  static std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.17g", value);
    return text.data();
  }

  vtkNew<vtkSphereSource> sphere_;
};

TEST_F(Surfaces, HoldTheSameInEachFormatAndEncoding) {
  const std::string mesh =
      mesh_of(written<vtkSTLWriter>("text.stl", [](auto& w) { w.SetFileTypeToASCII(); }));
  ASSERT_GT(mesh.size(), 1000U);
  EXPECT_EQ(mesh_of(written<vtkSTLWriter>("binary.stl", [](auto& w) { w.SetFileTypeToBinary(); })), mesh);
  EXPECT_EQ(mesh_of(written<vtkPLYWriter>("text.ply", [](auto& w) { w.SetFileTypeToASCII(); })), mesh);
  EXPECT_EQ(mesh_of(written<vtkPLYWriter>("little.ply", [](auto& w) { w.SetDataByteOrderToLittleEndian(); })),
            mesh);
  EXPECT_EQ(mesh_of(written<vtkPLYWriter>("big.ply", [](auto& w) { w.SetDataByteOrderToBigEndian(); })),
            mesh);
  EXPECT_EQ(mesh_of(written<vtkOBJWriter>("plain.obj")), mesh);
  EXPECT_EQ(mesh_of(written<vtkXMLPolyDataWriter>("appended.vtp")), mesh);
  EXPECT_EQ(mesh_of(written<vtkXMLPolyDataWriter>("text.vtp", [](auto& w) { w.SetDataModeToAscii(); })),
            mesh);
  EXPECT_EQ(mesh_of(written<vtkXMLPolyDataWriter>("lz4.vtp",
                                                  [](auto& w) {
                                                    w.SetDataModeToBinary();
                                                    w.SetCompressorTypeToLZ4();
                                                  })),
            mesh);
  for (const auto version :
       {vtkDataWriter::VTK_LEGACY_READER_VERSION_4_2, vtkDataWriter::VTK_LEGACY_READER_VERSION_5_1}) {
    const auto legacy = [&](int type) {
      return mesh_of(written<vtkPolyDataWriter>("legacy.vtk", [&](auto& w) {
        w.SetFileVersion(version);
        w.SetFileType(type);
      }));
    };
    EXPECT_TRUE(legacy(VTK_BINARY) == mesh) << version;
    const Json exact = info("legacy");
    EXPECT_GT(legacy(VTK_ASCII).size(), 1000U);  // its numbers have six digits
    EXPECT_NEAR(info("legacy")["volume"].get<double>(), exact["volume"].get<double>(), 5.0) << version;
  }
  write("xml.vtk", read("text.vtp"));
  EXPECT_TRUE(mesh_of("xml.vtk") == mesh);
  std::string stl = read("text.stl");
  stl.replace(stl.rfind("endsolid"), 8, "end solid");
  write("odd.stl", stl);
  EXPECT_TRUE(mesh_of("odd.stl") == mesh);
  write("plain.off", off_of_sphere());
  EXPECT_TRUE(mesh_of("plain.off") == mesh);
}

/// The same triangles in another order: the same shape, not the same bits.
TEST_F(Surfaces, OfStripsAreThoseOfTriangles) {
  vtkNew<vtkStripper> strips;
  strips->SetInputConnection(sphere_->GetOutputPort());
  strips->Update();
  ASSERT_GT(strips->GetOutput()->GetNumberOfStrips(), 0);
  vtkNew<vtkXMLPolyDataWriter> xml;
  xml->SetInputConnection(strips->GetOutputPort());
  xml->SetFileName((folder_ / "strips.vtp").c_str());
  xml->Write();
  vtkNew<vtkPolyDataWriter> legacy;
  legacy->SetInputConnection(strips->GetOutputPort());
  legacy->SetFileName((folder_ / "strips.vtk").c_str());
  legacy->Write();
  const std::string mesh = mesh_of(written<vtkPLYWriter>("triangles.ply"));
  ASSERT_GT(mesh.size(), 1000U);
  const Json of_triangles = info("triangles");
  for (const char* name : {"strips.vtp", "strips.vtk"}) {
    ASSERT_GT(mesh_of(name).size(), 1000U) << name;
    const Json of_strips = info("strips");
    EXPECT_NEAR(of_strips["volume"].get<double>(), of_triangles["volume"].get<double>(), 1e-3 * 4189.0)
        << name;
    EXPECT_EQ(of_strips["pieces"], 1) << name;
  }
}

/// Boxes that share no corners, as OFF.
class Boxes {
 public:
  Boxes& add(const Vec3& lower, double size, std::size_t faces = 6) {
    constexpr std::array<std::array<int, 4>, 6> quads{
        {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
    constexpr std::array<std::array<int, 3>, 8> corners{
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
    for (const auto& c : corners) {
      points_ += std::to_string(lower.x + size * c[0]) + " " + std::to_string(lower.y + size * c[1]) + " " +
                 std::to_string(lower.z + size * c[2]) + "\n";
    }
    for (std::size_t q = 0; q < faces; ++q) {
      polygons_ += "4";
      for (const int corner : quads[q])
        polygons_ += std::string(" ").append(std::to_string(corner + point_count_));
      polygons_ += " 255 0 0\n";
    }
    point_count_ += 8;
    polygon_count_ += static_cast<int>(faces);
    return *this;
  }
  [[nodiscard]] std::string off() const {
    return "OFF # by hand\n" + std::to_string(point_count_) + " " + std::to_string(polygon_count_) + " 0\n" +
           points_ + polygons_;
  }

 private:
  std::string points_;
  std::string polygons_;
  int point_count_ = 0;
  int polygon_count_ = 0;
};

class RoughSurfaces : public MeshProgram {
 protected:
  /// The report of one organ, meshed with about 1500 tets.
  [[nodiscard]] Json organ_of(const std::string& name, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> flags{"--tets", "1500"};
    flags.insert(flags.end(), more.begin(), more.end());
    const Json report = meshed(name, flags);
    return report.is_null() ? Json() : report["organs"][0];
  }
  static bool tells(const Json& organ, const std::string& part) {
    return std::ranges::any_of(organ["warnings"], [&](const Json& warning) {
      return warning.get<std::string>().find(part) != std::string::npos;
    });
  }
};

TEST_F(RoughSurfaces, PartsThatTouchInAnEdgeOrPointAreMeshed) {
  write("edge.off", Boxes().add({0, 0, 0}, 20).add({20, 20, 0}, 20).off());
  const Json edge = organ_of("edge.off");
  EXPECT_TRUE(tells(edge, "1 edge of four or more triangles")) << edge;
  EXPECT_NEAR(edge["volume"].get<double>(), 16000.0, 320.0);
  EXPECT_EQ(edge["parts"], 1);
  std::filesystem::remove_all(folder_ / "out");
  write("corner.off", Boxes().add({0, 0, 0}, 20).add({20, 20, 20}, 20).off());
  const Json corner = organ_of("corner.off");
  EXPECT_TRUE(tells(corner, "1 point where parts touch")) << corner;
  EXPECT_NEAR(corner["volume"].get<double>(), 16000.0, 400.0);
  std::filesystem::remove_all(folder_ / "out");
  write("wall.off", Boxes().add({0, 0, 0}, 20).add({20, 0, 0}, 20).off());  // with a duplicate wall
  EXPECT_NEAR(organ_of("wall.off")["volume"].get<double>(), 16000.0, 320.0);
}

TEST_F(RoughSurfaces, HolesAreClosedUpToASize) {
  write("open.off", Boxes().add({0, 0, 0}, 20, 5).off());
  expect_error(2, {"mesh", "open.off", "--quiet"},
               {"open.off: edge from point 0 (0, 0, 0) to point 3 (0, 20, 0)",
                "a hole of 4 edges, 28.28 mm across", "--close-holes 28.31 closes it"});
  const Json closed = organ_of("open.off", {"--close-holes", "28.31"});
  EXPECT_TRUE(tells(closed, "closed a hole of 4 edges, 28.28 mm across")) << closed;
  EXPECT_NEAR(closed["volume"].get<double>(), 8000.0, 160.0) << "the flat hole of a box";
}

TEST_F(RoughSurfaces, ThreeTrianglesAtAnEdgeAreNoHole) {
  // A box with a sheet on one of its edges.
  std::string off = Boxes().add({0, 0, 0}, 20).off();
  off.replace(off.find("8 6 0"), 5, "10 7 0");
  off.replace(off.find("4 0 3 2 1"), 0, "40 0 0\n40 0 20\n");
  write("fin.off", off + "4 1 8 9 5\n");
  expect_error(2, {"mesh", "fin.off", "--quiet", "--close-holes", "100"},
               {"fin.off: edge from point 1 (20, 0, 0) to point 5 (20, 0, 20)", "3 triangles", "4 edges",
                "two triangles at each edge, or four"});
}

TEST_F(RoughSurfaces, SelfIntersectionsAreTold) {
  write("cross.off", Boxes().add({0, 0, 0}, 20).add({10, 10, 10}, 20).off());
  const Json cross = organ_of("cross.off");
  EXPECT_TRUE(tells(cross, "cuts itself")) << cross;
  write("apart.off", Boxes().add({0, 0, 0}, 20).add({20.5, 0, 0}, 20).off());
  std::filesystem::remove_all(folder_ / "out");
  EXPECT_FALSE(tells(organ_of("apart.off"), "cuts itself"));
}

TEST_F(RoughSurfaces, UnitsAreTakenAndGuessed) {
  write("ball.off", Boxes().add({0, 0, 0}, 0.02).off());
  EXPECT_TRUE(tells(organ_of("ball.off"), "0.02 mm long: is it in another unit? (--unit m)"));
  std::filesystem::remove_all(folder_ / "out");
  const Json organ = organ_of("ball.off", {"--unit", "m"});
  EXPECT_NEAR(organ["volume"].get<double>(), 8000.0, 160.0);
  EXPECT_FALSE(tells(organ, "unit"));
}

TEST_F(RoughSurfaces, SeveralTakeTheNameOfTheirFolder) {
  std::filesystem::create_directory(folder_ / "knee");
  write("knee/a.off", Boxes().add({0, 0, 0}, 20).off());
  write("knee/b.off", Boxes().add({30, 0, 0}, 20).off());
  EXPECT_EQ(palpate({"mesh", "knee/a.off", "knee/b.off", "--tets", "500", "--quiet"}).exit_code, 0);
  EXPECT_EQ(Json::parse(read("knee-bodies/scene.json"))["name"], "knee");
  EXPECT_EQ(
      palpate({"mesh", "knee/a.off", "knee/b.off", "--tets", "500", "--quiet", "--out", "left"}).exit_code,
      0);
  EXPECT_EQ(Json::parse(read("left/scene.json"))["name"], "left");
}

}  // namespace
}  // namespace palpate::test
