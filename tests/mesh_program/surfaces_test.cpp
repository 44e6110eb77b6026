// Surfaces as VTK writes them; oracle: VTK, whose writers share no code with our readers.
#include <vtkNew.h>
#include <vtkOBJWriter.h>
#include <vtkPLYWriter.h>
#include <vtkPolyData.h>
#include <vtkSTLWriter.h>
#include <vtkSphereSource.h>
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
}

}  // namespace
}  // namespace palpate::test
