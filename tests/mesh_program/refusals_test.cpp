#include <chrono>
#include <csignal>
#include <thread>

#include "mesh_program/meshed.hpp"

/// What `palpate mesh` does not take, and what an interrupt leaves behind.
namespace palpate::test {
namespace {

TestMap box_map() {
  return {{12, 12, 12},
          [](int i, int j, int k) { return i > 2 && i < 9 && j > 2 && j < 9 && k > 2 && k < 9 ? 4 : 0; }};
}

class MeshRefusals : public MeshProgram {
 protected:
  void SetUp() override { write("map.nrrd", nrrd(box_map())); }
  void refuse(std::vector<std::string> arguments, const std::vector<std::string>& parts) const {
    arguments.insert(arguments.begin(), "mesh");
    expect_error(2, std::move(arguments), parts);
  }
};

TEST_F(MeshRefusals, Files) {
  refuse({"no.nrrd"}, {"no.nrrd", "no such file"});
  refuse({"map.png"}, {"map.png", ".nrrd", ".stl"});
  const std::string whole = nrrd(box_map());
  write("cut.nrrd", whole.substr(0, whole.size() - 100));
  refuse({"cut.nrrd"}, {"cut.nrrd"});
  write("text.nii", "this is no NIfTI file");
  refuse({"text.nii"}, {"text.nii", "header", "21 bytes", "348"});
  std::string nan = nifti(box_map());
  nan.replace(284, 4, "\x00\x00\xc0\x7f", 4);  // srow_x[1]
  write("nan.nii", nan);
  refuse({"nan.nii"}, {"nan.nii", "byte 284", "nan", "finite"});
  write("text.mha", "NDims = three\n");
  refuse({"text.mha"}, {"text.mha"});
  write("empty.nrrd", nrrd(TestMap({8, 8, 8}, [](int, int, int) { return 0; })));
  refuse({"empty.nrrd"}, {"empty.nrrd", "no voxel that is not 0"});
  write("voxels.raw", std::string(400UL * 400UL * 3UL, '\0'));
  write("elsewhere.nrrd",
        "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 400 400 3\nencoding: raw\ndata file: "
        "voxels.raw\n\n");
  refuse({"elsewhere.nrrd"}, {"elsewhere.nrrd", "no voxel that is not 0"});
  std::filesystem::create_directory(folder_ / "folder");
  refuse({"folder"}, {"folder", "0 DICOM series"});
  TestMap map = box_map();
  map.origin = {-20, 30, 40};
  write_series("capture", map, dicom_secondary_capture);
  refuse({"capture"}, {"capture", "position", "CT or MR slices"});
  EXPECT_FALSE(exists("map-bodies"));
}

TEST_F(MeshRefusals, ImagesThatAreNoLabelMaps) {
  write("flat.nrrd", "NRRD0004\ntype: unsigned char\ndimension: 2\nsizes: 2 2\nencoding: raw\n\nabcd");
  refuse({"flat.nrrd"}, {"flat.nrrd", "2 dimensions", "three"});
  write("ct.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 1\nencoding: ascii\n\n0 1 0.5 3\n");
  refuse({"ct.nrrd"}, {"ct.nrrd", "voxel 2", "0.5", "whole number >= 0"});
  write("hu.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 1\nencoding: ascii\n\n0 1 2 -1000\n");
  refuse({"hu.nrrd"}, {"hu.nrrd", "voxel 3", "-1000"});
  write("large.nrrd",
        "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 60000 4000 1\nencoding: raw\n\nabcd");
  refuse({"large.nrrd"}, {"large.nrrd", "voxels of 240000000 bytes in a file of 81"});
  write("layers.seg.nrrd",
        "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 2 2 2\nkinds: list domain domain domain\n"
        "encoding: ascii\n\n0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1\n");
  refuse({"layers.seg.nrrd"}, {"layers.seg.nrrd", "overlapping segments"});
}

TEST_F(MeshRefusals, Flags) {
  refuse({}, {"INPUT"});
  refuse({"map.nrrd", "--tetz", "5"}, {"--tetz", "'--tets'"});
  refuse({"map.nrrd", "--tets", "many"}, {"--tets", "'many'"});
  refuse({"map.nrrd", "--size", "0"}, {"--size", "'0'", "> 0"});
  refuse({"map.nrrd", "--size", "2", "--tets", "100"}, {"--size", "--tets", "one of them"});
  refuse({"map.nrrd", "--only", "lable 4"}, {"--only", "'lable 4'", "'label 4'"});
  refuse({"map.nrrd", "--tets", "skull=10"}, {"--tets", "'skull'", "'label 4'"});
  refuse({"map.nrrd", "--gap", "50"}, {"--gap", "20 voxels"});
  refuse({"map.nrrd", "map.nrrd"}, {"2 inputs"});
  refuse({"map.nrrd", "--space", "world"}, {"--space", "'world'"});
  write("table.txt", "1 bone 1 2 3\n2 fat 300\n");
  refuse({"map.nrrd", "--labels", "table.txt"}, {"table.txt", "line 2", "'2 fat 300'"});
  write("twice.txt", "1 bone 1 2 3\n1 fat 1 2 3\n");
  refuse({"map.nrrd", "--labels", "twice.txt"}, {"twice.txt", "line 2", "label 1 again"});
  std::filesystem::create_directory(folder_ / "map-bodies");
  refuse({"map.nrrd"}, {"map-bodies", "--out"});
}

TEST_F(MeshRefusals, Surfaces) {
  write("open.stl", box_stl({0, 0, 0}, {1, 1, 1}, true));
  refuse({"open.stl"}, {"open.stl", "3 edges", "closed surface"});
  write("empty.obj", "# nothing\n");
  refuse({"empty.obj"}, {"empty.obj", "no triangles"});
  write("text.vtp", "no XML");
  refuse({"text.vtp"}, {"text.vtp", "no triangles"});
  refuse({"no.ply"}, {"no.ply", "no such file"});
}

TEST_F(MeshRefusals, MeshesThatAreTooLargeFail) {
  expect_error(1, {"mesh", "map.nrrd", "--size", "0.1", "--max-points", "2000", "--quiet"},
               {"more than 2000 points"});
  EXPECT_FALSE(exists("map-bodies"));
}

TEST_F(MeshRefusals, AnInterruptLeavesNothing) {
  Process process({"mesh", "map.nrrd", "--size", "0.05", "--max-points", "50000000"}, folder_.path());
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  ASSERT_TRUE(process.running());
  process.send(SIGINT);
  const Finished finished = process.wait();
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_NE(finished.err.find("interrupted; nothing was written"), std::string::npos) << finished.err;
  EXPECT_FALSE(exists("map-bodies"));
}

TEST_F(MeshRefusals, TheTerminalShowsOneLine) {
  const std::string shown = palpate_on_terminal({"mesh", "map.nrrd", "--tets", "20000"}, folder_.path(), 60);
  EXPECT_NE(shown.find("meshing label 4 (1 of 1)"), std::string::npos) << shown;
  EXPECT_NE(shown.find("map-bodies/scene.json: 1 body"), std::string::npos) << shown;
}

}  // namespace
}  // namespace palpate::test
