#include <csignal>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Generate : public CommandTest {};

TEST_F(Generate, BoxHasFiveTetsACell) {
  output_of({"generate", "box", "--cells", "4", "3", "2", "--size", "0.4", "0.3", "0.1"});
  const Json info = json_of({"info", "box.vtu", "--json"});
  EXPECT_EQ(info["points"], 5 * 4 * 3);
  EXPECT_EQ(info["tets"], 5 * 4 * 3 * 2);
  EXPECT_NEAR(info["volume"], 0.4 * 0.3 * 0.1, 1e-15);
  EXPECT_EQ(info["lower"], Json::parse("[-0.2, -0.15, -0.05]"));
  EXPECT_EQ(info["upper"], Json::parse("[0.2, 0.15, 0.05]"));
  EXPECT_EQ(info["edge_length"]["min"].get<double>(), 0.05);
}

TEST_F(Generate, BallFillsItsSphere) {
  output_of({"generate", "ball", "--radius", "2", "--resolution", "9", "--out", "b.vtu"});
  const Json info = json_of({"info", "b.vtu", "--json"});
  EXPECT_EQ(info["tets"], 20 * 9 * 9 * 9);
  EXPECT_NEAR(info["upper"][2], 2.0, 1e-12);
  const double sphere = 4.0 / 3.0 * 3.14159265358979 * 8.0;
  EXPECT_GT(info["volume"], 0.97 * sphere);
  EXPECT_LT(info["volume"], sphere);
}

TEST_F(Generate, StackingIsAsAsked) {
  output_of({"generate", "stacking", "--count", "3", "--cells", "4", "5", "1", "--size", "0.2", "0.25",
             "0.02", "--gap", "0.01", "--seed", "7", "--out", "three.json"});
  const Json scene = Json::parse(read("three.json"));
  ASSERT_EQ(scene["bodies"].size(), 3U);
  EXPECT_EQ(scene["bodies"][1]["box"]["cells"], Json::parse("[4, 5, 1]"));
  EXPECT_EQ(scene["bodies"][1]["box"]["size"], Json::parse("[0.2, 0.25, 0.02]"));
  EXPECT_EQ(scene["bodies"][0]["obstacle"], true);
  EXPECT_NEAR(scene["bodies"][2]["translate"][2], 0.01 + 2 * 0.03, 1e-15);
  output_of({"generate", "stacking", "--count", "3", "--seed", "8", "--out", "other.json"});
  EXPECT_NE(Json::parse(read("other.json"))["bodies"][1]["rotate"], scene["bodies"][1]["rotate"]);
}

TEST_F(Generate, StackingByDefaultIsThePapersTableOne) {
  output_of({"generate", "stacking"});
  const Json total = json_of({"info", "stacking.json", "--json"})["total"];
  EXPECT_EQ(total["points"], 4840);
  EXPECT_EQ(total["edges"], 19620);
  EXPECT_EQ(total["triangles"], 9600);
  EXPECT_EQ(total["tets"], 10000);
}

TEST_F(Generate, OnlyANamedFileIsReplaced) {
  output_of({"generate", "box"});
  const std::string before = read("box.vtu");
  expect_error(2, {"generate", "box", "--cells", "2", "2", "2"}, {"box.vtu", "an existing file", "--out"});
  EXPECT_EQ(read("box.vtu"), before);
  output_of({"generate", "box", "--cells", "2", "2", "2", "--out", "box.vtu"});
  EXPECT_EQ(json_of({"info", "box.vtu", "--json"})["tets"], 40);
}

TEST_F(Generate, NamesOfLabelMapsAndPlatesAreAsOfMeshes) {
  for (const char* name : {"eye.seg.nrrd", "orbit.seg.nrrd", "plate.vtu"}) write(name, "mine");
  expect_error(2, {"generate", "eye-labels"}, {"eye.seg.nrrd", "an existing file", "--out"});
  expect_error(2, {"generate", "orbit-labels"}, {"orbit.seg.nrrd", "an existing file", "--out"});
  expect_error(2, {"generate", "orbit-plate"}, {"plate.vtu", "an existing file", "--out"});
  for (const char* name : {"eye.seg.nrrd", "orbit.seg.nrrd", "plate.vtu"}) EXPECT_EQ(read(name), "mine");
  output_of({"generate", "eye-labels", "--voxel", "4", "--out", "eye.seg.nrrd"});
  EXPECT_TRUE(read("eye.seg.nrrd").starts_with("NRRD"));
}

TEST_F(Generate, AnInterruptLeavesNoFile) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Process process({"generate", "ball", "--resolution", "40"}, folder_.path());
    wait_until([&] { return process.handles(signal); });
    process.send(signal);
    const Finished finished = process.wait();
    EXPECT_EQ(finished.exit_code, 1);
    EXPECT_EQ(finished.err, "palpate: error: interrupted; nothing was written\n");
    EXPECT_TRUE(names_in(folder_.path()).empty());
  }
}

TEST_F(Generate, AnInterruptWhileWritingLeavesNoHiddenFile) {
  const auto writes = [&] { return !names_in(folder_.path()).empty(); };
  Process process({"generate", "ball", "--resolution", "50", "--out", "b.vtu"}, folder_.path());
  wait_until(writes);
  process.send(SIGTERM);
  const Finished finished = process.wait();
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_EQ(finished.err, "palpate: error: interrupted; b.vtu is complete\n");
  EXPECT_EQ(names_in(folder_.path()), std::vector<std::string>{"b.vtu"});
  EXPECT_EQ(json_of({"info", "b.vtu", "--json"})["tets"], 20 * 50 * 50 * 50);
}

TEST_F(Generate, WritesTheOrgansOfTheMedicalScenes) {
  const std::string said = output_of({"generate", "skull"});
  for (const char* name :
       {"skull/skull.vtu", "skull/upper-jaw.vtu", "skull/lower-jaw.vtu", "skull/soft-tissue.vtu"}) {
    EXPECT_NE(said.find(name), std::string::npos);
    EXPECT_GT(json_of({"info", name, "--json"})["tets"], 1000);
  }
  expect_error(2, {"generate", "skull"}, {"skull", "an existing file or folder", "--out"});
  output_of({"generate", "skull", "--out", "skull"});
  write("file", "");
  expect_error(2, {"generate", "eye", "--out", "file"}, {"file", "folder"});
}

TEST_F(Generate, RefusesWhatItCannotWrite) {
  expect_error(2, {"generate", "box", "--out", "box.msh"}, {"--out", "'box.msh'", ".vtu"});
  expect_error(2, {"generate", "stacking", "--out", "s.vtu"}, {"--out", ".json"});
  for (const char* kind : {"eye-labels", "orbit-labels"})
    expect_error(2, {"generate", kind, "--out", "mesh.vtu"}, {"--out", "'mesh.vtu'", ".nrrd"});
  expect_error(2, {"generate", "orbit-plate", "--out", "map.nrrd"}, {"--out", "'map.nrrd'", ".vtu"});
  expect_error(1, {"generate", "ball", "--out", "no/such/ball.vtu"}, {"no/such/ball.vtu", "folder"});
  expect_error(2, {"generate", "ball", "--resolution", "257"}, {"resolution", "257", "256"});
  expect_error(2, {"generate", "stacking", "--count", "1000000000"}, {"--count", "100000"});
  expect_error(2, {"generate", "orbit-labels", "--defect", "99,1"}, {"--defect: width: found 99"});
  expect_error(2, {"generate", "orbit-plate", "--at", "99,1"}, {"--at: x: found 99"});
  expect_error(2, {"generate", "orbit-plate", "--thickness", "99"}, {"--thickness: found 99"});
  expect_error(1, {"generate", "skull", "--out", "/proc/no-folder"},
               {"/proc/no-folder", "a folder to write to"});
  expect_error(2, {"generate", "box", "--size", "1e308", "1", "1"}, {"size", "1e+308", "1e100"});
  EXPECT_TRUE(names_in(folder_.path()).empty());
}

}  // namespace
}  // namespace palpate::test
