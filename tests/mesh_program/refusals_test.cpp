#include <csignal>
#include <sys/stat.h>

#include "mesh_program/meshed.hpp"
#include "support/file_size_limit.hpp"

/// Input that `palpate mesh` refuses, and the files after an interrupt.
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
  EXPECT_EQ(palpate({"mesh", "cut.nrrd"}).err.find("(0x"), std::string::npos) << "an address of ITK's";
  write("text.nii", "this is no NIfTI file");
  refuse({"text.nii"}, {"text.nii", "header", "21 bytes", "348"});
  std::string nan = nifti(box_map());
  nan.replace(284, 4, "\x00\x00\xc0\x7f", 4);  // srow_x[1]
  write("nan.nii", nan);
  refuse({"nan.nii"}, {"nan.nii", "byte 284", "nan", "finite"});
  std::string flat = nifti(box_map());
  flat.replace(88, sizeof(float), sizeof(float), '\0');  // pixdim[3]
  write("flat.nii", flat);
  refuse({"flat.nii"}, {"flat.nii: header, byte 88: found 0, expected the size of a voxel in mm"});
  write("text.mha", "NDims = three\n");
  refuse({"text.mha"}, {"text.mha: found a header that cannot be read, expected a label map"});
  for (const char* name : {"nothing.mha", "nothing.nii", "nothing.nrrd"}) {
    write(name, "");
    refuse({name}, {std::string(name) + ": found an empty file"});
  }
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

std::string meta_header(const std::string& more, const std::string& file) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 12 12 12\nElementType = MET_UCHAR\n" + more +
         "ElementDataFile = " + file + '\n';
}

TEST_F(MeshRefusals, CutMetaImages) {
  const TestMap map = box_map();
  const std::string voxels(map.labels.begin(), map.labels.end());
  const auto accept = [&](const std::string& name) {
    const Finished finished = palpate({"mesh", name, "--out", "out", "--replace", "--size", "3", "--quiet"});
    EXPECT_EQ(finished.exit_code, 0) << name << finished.err;
  };
  const std::string whole = meta_image(map);
  write("cut.mha", whole.substr(0, whole.size() - 728));
  refuse({"cut.mha"}, {"cut.mha: voxels: found 1000 bytes, expected 1728 bytes: the file is cut"});
  write("short.raw", voxels.substr(1));
  write("cut.mhd", meta_header("", "short.raw"));
  refuse({"cut.mhd"}, {"short.raw: voxels: found 1727 bytes", "1728"});
  write("end.mhd", meta_header("HeaderSize = -1\n", "short.raw"));
  refuse({"end.mhd"}, {"short.raw", "1727", "1728"});
  write("skip.mhd", meta_header("HeaderSize = 2\n", "whole.raw"));
  write("whole.raw", "ab" + voxels);
  accept("skip.mhd");
  write("whole.raw", voxels + " ");
  refuse({"skip.mhd"}, {"whole.raw", "1727", "1728"});

  const std::string packed = zlib_stored(voxels);
  const auto compressed = [](std::size_t bytes) {
    return meta_header("CompressedData = True\nCompressedDataSize = " + std::to_string(bytes) + '\n',
                       "LOCAL");
  };
  write("packed.mha", compressed(packed.size()) + packed);
  accept("packed.mha");
  write("packed.mha", compressed(packed.size()) + packed.substr(0, 900));
  refuse({"packed.mha"}, {"packed.mha: voxels: found 900 compressed bytes, expected 1739 bytes"});
  write("packed.mha", compressed(900) + packed.substr(0, 900));
  refuse({"packed.mha"}, {"packed.mha: voxels: found compressed data of 893 bytes, expected 1728 bytes"});

  std::string text;
  for (const int label : map.labels) text += std::to_string(label) + ' ';
  write("text.mha", meta_header("BinaryData = False\n", "LOCAL") + text);
  accept("text.mha");
  write("text.mha", meta_header("BinaryData = False\n", "LOCAL") + text.substr(0, 2000));
  refuse({"text.mha"}, {"text.mha: voxels: found 1000 numbers, expected 1728"});
}

TEST_F(MeshRefusals, MetaImagesWithAFileForEachSlice) {
  const TestMap map = box_map();
  std::string list = meta_header("", "LIST");
  for (int k = 0; k < 12; ++k) {
    const std::string name = "slice" + std::to_string(100 + k) + ".raw";
    list += name + '\n';
    write(name, std::string(map.labels.begin() + 144 * k, map.labels.begin() + 144 * (k + 1)));
  }
  write("list.mhd", list);
  write("some.mhd", list.substr(0, list.size() - 13));
  write("numbered.mhd", meta_header("", "slice1%02d.raw 0 11 1"));
  for (const char* name : {"list.mhd", "numbered.mhd"}) {
    const Finished finished = palpate({"mesh", name, "--out", name + std::string("-out"), "--size", "3"});
    EXPECT_EQ(finished.exit_code, 0) << name << finished.err;
  }
  refuse({"some.mhd"}, {"some.mhd: ElementDataFile: found 11 files, expected 12"});
  write("string.mhd", meta_header("", "slice%s.raw 0 11 1"));  // would crash MetaIO
  refuse({"string.mhd"}, {"string.mhd: ElementDataFile: found 'slice%s.raw'", "%03d"});
  write("few.mhd", meta_header("", "slice1%02d.raw 0 5 1"));
  refuse({"few.mhd"}, {"few.mhd: ElementDataFile", "12 files"});
  write("slice103.raw", "short");
  for (const char* name : {"list.mhd", "numbered.mhd"})
    refuse({name}, {"slice103.raw: voxels: found 5 bytes, expected 144"});
  std::filesystem::remove(folder_ / "slice103.raw");
  for (const char* name : {"list.mhd", "numbered.mhd"}) refuse({name}, {"slice103.raw", "no such file"});
}

TEST_F(MeshRefusals, CutNifti) {
  const std::string whole = nifti(box_map());
  write("cut.nii", whole.substr(0, whole.size() - 1));
  refuse({"cut.nii"}, {"cut.nii: voxels: found the end of the file after 2079 bytes, expected 2080"});
  const std::string packed = gzip_stored(whole);
  write("whole.nii.gz", packed);
  const Finished finished = palpate({"mesh", "whole.nii.gz", "--out", "out", "--size", "3"});
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  write("cut.nii.gz", packed.substr(0, packed.size() / 2));
  refuse({"cut.nii.gz"}, {"cut.nii.gz: voxels", "2080"});
  write("short.nii.gz", gzip_stored(whole.substr(0, whole.size() - 1)));
  refuse({"short.nii.gz"}, {"short.nii.gz: voxels", "2079", "2080"});
  std::string damaged = packed;
  damaged[1500] = '\x01';
  write("sum.nii.gz", damaged);
  refuse({"sum.nii.gz"}, {"sum.nii.gz: found damaged compressed data"});
  const auto offset = [&](const char* bytes, const std::string& found) {
    std::string header = whole;
    write("offset.nii", header.replace(108, 4, bytes, 4));
    refuse({"offset.nii"}, {"offset.nii: header, byte 108: found " + found});
  };
  offset("\x00\x00\xc0\x7f", "nan");
  offset("\xca\xf2\x49\x71", "1");  // 1e30
  offset("\x00\x00\x80\xbf", "-1");
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
  const std::string metres = "space dimension: 3\nspace directions: (1e9,0,0) (0,1e9,0) (0,0,1e9)\n";
  write("huge.nrrd",
        "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 1\n" + metres + "encoding: ascii\n\n0 1 1 0\n");
  refuse({"huge.nrrd"}, {"huge.nrrd", "a voxel of 1e+09 mm", "1e-9 to 1e6"});
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
  refuse({"map.nrrd", "--size", "2", "--tets", "100"}, {"--size", "--tets", "only one of them"});
  refuse({"map.nrrd", "--only", "lable 4"}, {"--only", "'lable 4'", "'label 4'"});
  refuse({"map.nrrd", "--tets", "skull=10"}, {"--tets", "'skull'", "'label 4'"});
  refuse({"map.nrrd", "--gap", "50"}, {"--gap", "20 voxels"});
  refuse({"map.nrrd", "map.nrrd"}, {"2 inputs"});
  refuse({"map.nrrd", "--unit", "m"}, {"--unit", "a label map"});
  refuse({"map.nrrd", "--close-holes", "1"}, {"--close-holes", "a label map"});
  write("box.stl", box_stl({0, 0, 0}, {1, 1, 1}, false));
  refuse({"box.stl", "--labels", "no.txt"}, {"--labels", "surfaces", "a label map"});
  refuse({"box.stl", "--smoothing", "1"}, {"--smoothing", "surfaces", "a label map"});
  refuse({"map.nrrd", "--space", "world"}, {"--space", "'world'"});
  write("table.txt", "1 bone 1 2 3\n2 fat 300\n");
  refuse({"map.nrrd", "--labels", "table.txt"}, {"table.txt", "line 2", "'2 fat 300'"});
  write("twice.txt", "1 bone 1 2 3\n1 fat 1 2 3\n");
  refuse({"map.nrrd", "--labels", "twice.txt"}, {"twice.txt", "line 2", "label 1 for the second time"});
  std::filesystem::create_directory(folder_ / "map-bodies");
  refuse({"map.nrrd"}, {"map-bodies", "--out"});
}

TEST_F(MeshRefusals, Surfaces) {
  write("open.stl", box_stl({0, 0, 0}, {1, 1, 1}, true));
  refuse({"open.stl"}, {"open.stl", "a hole of 3 edges", "a closed surface"});
  write("huge.stl", box_stl({0, 0, 0}, {1e10, 1e10, 1e10}));  // CGAL's mesher would not end
  refuse({"huge.stl"}, {"huge.stl", "a diagonal of 1.732e+10 mm", "1e-9 to 1e9 mm"});
  write("short.off", "OFF\n4 4 0\n0 0 0\n1 0\n0 1 0\n0 0 1\n3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n");
  refuse({"short.off"}, {"short.off: line 4: found the end of the line", "three coordinates"});
  write("empty.obj", "# nothing\n");
  refuse({"empty.obj"}, {"empty.obj", "no triangles"});
  write("text.vtp", "no XML");
  refuse({"text.vtp"}, {"text.vtp"});
  refuse({"no.ply"}, {"no.ply", "no such file"});
  // Files that crash VTK's readers.
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  write("length.ply", ply + "-3 0 1 2\n");
  refuse({"length.ply"}, {"length.ply: line 13: found -3", "a length of a list"});
  write("index.ply", ply + "3 0 1 999999999\n");
  refuse({"index.ply"}, {"index.ply: line 13: found 999999999", "0 to 2"});
  std::string list = ply;
  list.replace(list.find("float x"), 7, "list uchar float x");
  write("list.ply", list + "3 0 1 2\n");
  refuse({"list.ply"}, {"list.ply: element vertex: found not one number x"});
  write("cut.ply", ply.substr(0, 160));
  refuse({"cut.ply"}, {"cut.ply: "});
  write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 999999999\n");
  refuse({"index.obj"}, {"index.obj: line 4", "999999999", "3 points"});
  write("count.stl", std::string(80, ' ') + "\xff\xff\xff\xff and some");
  refuse({"count.stl"}, {"count.stl: found 93 bytes", "214748364834"});
  write("offsets.vtp", R"(<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="1" NumberOfPolys="2">
<Points><DataArray type="Float32" NumberOfComponents="3">0 0 0</DataArray></Points>
<Polys><DataArray type="Int32" Name="connectivity">0 0 0</DataArray>
<DataArray type="Int32" Name="offsets">3 2</DataArray></Polys></Piece></PolyData></VTKFile>)");
  refuse({"offsets.vtp"}, {"offsets.vtp: offsets, number 1: found 2", "3 or more"});
}

TEST_F(MeshRefusals, DamagedNrrdInShortWords) {  // the library's own message is of ten lines
  const std::string head = "NRRD0004\ntype: unsigned char\ndimension: 3\n";
  const std::string data = "encoding: ascii\n\n1 1 1 1 1 1 1 1\n";
  write("sizes.nrrd", head + "sizes: 2 2\n" + data);
  refuse({"sizes.nrrd"},
         {"sizes.nrrd: found 'sizes' that cannot be read (parsed 2 values, but dimension is 3), "});
  write("axes.nrrd", head +
                         "space: left-posterior-superior\nsizes: 2 2 2\nspace directions: (nan,0,0) (0,1,0) "
                         "(0,0,1)\n" +
                         data);
  refuse({"axes.nrrd"}, {"axes.nrrd: found 'space directions' that cannot be read ("});
  write("cut.nrrd", head + "sizes: 2 2 2\nencoding: ascii\n\n1 1 1");
  refuse({"cut.nrrd"}, {"cut.nrrd: found damaged data (couldn't parse element 4 of 8), "});
}

TEST_F(MeshRefusals, DamagedOffAndVtk) {
  const std::string off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const auto bad = [&](const std::string& name, const std::string& text,
                       const std::vector<std::string>& parts) {
    write(name, text);
    refuse({name}, parts);
  };
  bad("cut.off", off.substr(0, 20), {"cut.off: line"});
  bad("points.off", "OFF\n999999999 1 0\n0 0 0\n",
      {"points.off: line 2: found \"999999999\"", "the number of points"});
  bad("corner.off", off.substr(0, off.size() - 2) + "3\n",
      {"corner.off: line 6: found point number 3", "0 to 2"});
  bad("more.off", off + "3 0 2 1\n",
      {"more.off: line 7: found \"3\"", "the end of the file after 1 polygons"});
  bad("corners.off", "OFF\n1 1 0\n0 0 0\n99999 0\n", {"corners.off: line 4: found \"99999\""});
  bad("four.off", "4OFF\n3 1 0\n", {"four.off: line 1", "three coordinates"});
  bad("binary.off", "OFF BINARY\n3 1 0\n", {"binary.off: line 1", "in text"});
  bad("nan.off", "OFF\n3 1 0\n0 nan 0\n1 0 0\n0 1 0\n3 0 1 2\n", {"nan.off: line 3", "finite"});
  const std::string vtk =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
  bad("index.vtk", vtk + "POLYGONS 1 4\n3 0 1 7\n", {"index.vtk: polygon 0: found point 7", "3 points"});
  bad("count.vtk", vtk + "POLYGONS 2 4\n3 0 1 2\n", {"count.vtk: cell 1", "the cell list"});
  bad("strip.vtk", vtk + "TRIANGLE_STRIPS 1 4\n3 0 1 -2\n", {"strip.vtk: strip 0: found point -2"});
  bad("cut.vtk", vtk + "POLYGONS 1 4\n3 0 1",
      {"cut.vtk: line 7", "as many as the rest of the file can hold"});
  bad("none.vtk", vtk, {"none.vtk", "no triangles"});
  bad("tets.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 "
      "0 1\n"
      "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n",
      {"tets.vtk", "a mesh of tets", "'palpate new' makes a scene of it"});
  bad("pointer.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n",
      {"pointer.stl", "git-LFS", "git lfs pull"});
  bad("pointer.nii.gz", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n",
      {"pointer.nii.gz", "git-LFS"});
}

TEST_F(MeshRefusals, PipesAndDevices) {
  for (const char* name : {"map.nhdr", "pipe.nrrd", "pipe.stl", "labels.txt", "voxels.raw"})
    ASSERT_EQ(::mkfifo((folder_ / name).c_str(), 0600), 0);
  refuse({"pipe.nrrd"}, {"pipe.nrrd", "not a regular file"});
  refuse({"map.nhdr"}, {"map.nhdr", "not a regular file"});
  refuse({"pipe.stl"}, {"pipe.stl", "not a regular file"});
  refuse({"map.nrrd", "--labels", "labels.txt"}, {"labels.txt", "not a regular file"});
  write("map.mhd",
        "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = "
        "voxels.raw\n");
  refuse({"map.mhd"}, {"voxels.raw", "not a regular file"});
  write(
      "elsewhere.nrrd",
      "NRRD0004\ntype: unsigned char\ndimension: 3\nsizes: 4 4 4\nencoding: raw\ndata file: voxels.raw\n\n");
  refuse({"elsewhere.nrrd"}, {"voxels.raw", "not a regular file"});
  std::filesystem::create_symlink("/dev/zero", folder_ / "zero.nii");
  refuse({"zero.nii"}, {"zero.nii", "not a regular file"});
}

TEST_F(MeshRefusals, ASceneIsNotReplacedUnasked) {
  const std::vector<std::string> mesh{"mesh", "map.nrrd", "--size", "3", "--quiet"};
  const auto with = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), mesh.begin(), mesh.end());
    return flags;
  };
  std::filesystem::create_directory(folder_ / "out");
  write("out/notes.txt", "mine");
  output_of(with({"--out", "out"}));
  const std::string made = read("out/scene.json");
  write("out/scene.json", "changed");
  expect_error(2, with({"--out", "out"}), {"out/scene.json: found an existing file", "--replace"});
  expect_error(2, with({"--out", "out", "--conforming"}), {"out/scene.json", "--replace"});
  EXPECT_EQ(read("out/scene.json"), "changed");
  output_of(with({"--out", "out", "--replace"}));
  EXPECT_EQ(read("out/scene.json"), made);
  EXPECT_EQ(read("out/notes.txt"), "mine");
  output_of(with({}));
  expect_error(2, with({}), {"map-bodies: found an existing folder", "--out", "--replace"});
  output_of(with({"--replace"}));
}

/// Where the new meshes cannot all be written, the old scene stays as it was: with meshes of another size,
/// the points that it names would be others.
TEST_F(MeshRefusals, ASceneIsReplacedAsAWhole) {
  TestMap two = box_map();
  for (std::size_t i = two.labels.size() / 2; i < two.labels.size(); ++i) two.labels[i] *= 2;
  write("two.nrrd", nrrd(two));
  const auto mesh = [&](const std::string& map, const std::string& size) {
    return palpate({"mesh", map, "--size", size, "--out", "out", "--replace", "--quiet"});
  };
  ASSERT_EQ(mesh("two.nrrd", "3").exit_code, 0);
  const std::vector<std::string> names{"label-4.vtu", "label-8.vtu", "scene.json"};
  std::vector<std::string> before;
  for (const std::string& name : names) before.push_back(read("out/" + name));
  Finished failed;
  {
    const FileSizeLimit limit(before[0].size() + before[1].size());
    failed = mesh("two.nrrd", "0.7");
  }
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_NE(failed.err.find("File too large"), std::string::npos) << failed.err;
  EXPECT_EQ(names_in(folder_ / "out").size(), names.size()) << "no part of the new scene is left";
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(read("out/" + names[i]), before[i]) << names[i];
  std::filesystem::remove(folder_ / "out/label-8.vtu");
  std::filesystem::create_directory(folder_ / "out/label-8.vtu");
  const Finished refused = mesh("two.nrrd", "2");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("out/label-8.vtu: found a folder"), std::string::npos) << refused.err;
  EXPECT_EQ(read("out/label-4.vtu"), before[0]);
  std::filesystem::remove(folder_ / "out/label-8.vtu");
  ASSERT_EQ(mesh("two.nrrd", "3").exit_code, 0);
  const Finished one = mesh("map.nrrd", "3");
  EXPECT_NE(one.err.find("label-8.vtu: in the folder of the scene, but not of it"), std::string::npos)
      << one.err;
}

TEST_F(MeshRefusals, MeshesThatAreTooLargeFail) {
  expect_error(1, {"mesh", "map.nrrd", "--size", "0.1", "--max-points", "2000", "--quiet"},
               {"more than 2000 points"});
  EXPECT_FALSE(exists("map-bodies"));
}

TEST_F(MeshRefusals, AnInterruptLeavesNothing) {
  Process process({"mesh", "map.nrrd", "--size", "0.05", "--max-points", "50000000"}, folder_.path());
  wait_until([&] { return process.handles(SIGINT); });
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
