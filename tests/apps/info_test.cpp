#include <cmath>

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

class Info : public CommandTest {};

/// Corner of a cube: edges 1 and sqrt 2, dihedral angles 90 and acos(1/sqrt 3), volume 1/6.
const std::vector<std::string> corner{"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
const std::vector<std::string> inverted_corner{"0 0 0", "0 1 0", "1 0 0", "0 0 1"};

TEST_F(Info, StatisticsOfOneTet) {
  write("tet.mesh", one_tet(corner));
  const Json info = json_of({"info", "tet.mesh", "--json"});
  EXPECT_EQ(info["kind"], "mesh");
  EXPECT_EQ(info["file"], "tet.mesh");
  EXPECT_EQ(info["points"], 4);
  EXPECT_EQ(info["edges"], 6);
  EXPECT_EQ(info["triangles"], 4);
  EXPECT_EQ(info["tets"], 1);
  EXPECT_NEAR(info["volume"], 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(info["edge_length"]["min"], 1.0, 1e-15);
  EXPECT_NEAR(info["edge_length"]["mean"], (1.0 + std::sqrt(2.0)) / 2.0, 1e-15);
  EXPECT_NEAR(info["edge_length"]["max"], std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(info["dihedral_angle"]["max"], 90.0, 1e-12);
  EXPECT_NEAR(info["dihedral_angle"]["min"], std::acos(1.0 / std::sqrt(3.0)) * 180.0 / M_PI, 1e-12);
  EXPECT_EQ(info["lower"], Json::parse("[0, 0, 0]"));
  EXPECT_EQ(info["upper"], Json::parse("[1, 1, 1]"));
  EXPECT_TRUE(info["reoriented_tets"].empty());
  EXPECT_TRUE(info["dropped"].empty());
  EXPECT_EQ(info["unreferenced_points"], 0);
}

TEST_F(Info, TextSaysTheSame) {
  write("tet.mesh", one_tet(corner));
  const std::string text = output_of({"info", "tet.mesh"});
  for (const char* part : {"tet.mesh: Medit", "points          4", "edges           6", "triangles       4",
                           "tets            1", "min 1, mean 1.207, max 1.414", "volume          0.166667"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in:\n" << text;
  }
  EXPECT_EQ(text.find("note"), std::string::npos);
}

TEST_F(Info, NamesBodiesThatAreTooCoarseForEachOther) {
  write("sheets.json", R"({"bodies": [
    {"name": "low", "box": {"cells": [4, 4, 1], "size": [0.1, 0.1, 0.002]}, "obstacle": true},
    {"name": "high", "box": {"cells": [5, 5, 1], "size": [0.1, 0.1, 0.002]}, "translate": [0, 0, 0.01], "material": {}},
    {"name": "fine", "box": {"cells": [40, 40, 1], "size": [0.1, 0.1, 0.002]}, "translate": [0, 0, 0.02],
     "material": {}}]})");
  const Json json = json_of({"info", "sheets.json", "--json"});
  ASSERT_EQ(json["too_coarse"].size(), 1U);
  EXPECT_EQ(json["too_coarse"][0]["bodies"], (Json{"low", "high"}));
  EXPECT_NEAR(json["too_coarse"][0]["thickness"][0].get<double>(), 0.002, 1e-9);
  const Finished text = palpate({"info", "sheets.json"});
  EXPECT_NE(text.out.find("too coarse      low (edges of "), std::string::npos) << text.out;
  const Finished detect = palpate({"detect", "sheets.json"});
  EXPECT_NE(detect.err.find("palpate: too coarse      low (edges of "), std::string::npos) << detect.err;
  EXPECT_EQ(json_of({"detect", "sheets.json", "--format", "json"})["too_coarse"], json["too_coarse"]);
}

TEST_F(Info, TellsOfBodiesThatCrossWithoutAContact) {
  const std::string bodies = R"("bodies": [
    {"name": "low", "box": {"cells": [1, 1, 1], "size": [0.2, 0.02, 0.02]}, "obstacle": true},
    {"name": "high", "box": {"cells": [1, 1, 1], "size": [0.02, 0.2, 0.02]}, "translate": [0.09, -0.09, 0.019],
     "material": {}}]})";
  write("bars.json", R"({"contact": {"edge_contacts": false}, )" + bodies);
  write("edges.json", "{" + bodies);
  const std::string line =
      "no contact      in 1 pair of bodies that cross edge on edge: contact.edge_contacts is false\n";
  EXPECT_NE(output_of({"info", "bars.json"}).find(line), std::string::npos);
  EXPECT_EQ(json_of({"info", "bars.json", "--json"})["unseen_pairs_at_start"], 1);
  const Finished detect = palpate({"detect", "bars.json", "--format", "json"});
  EXPECT_NE(detect.err.find("palpate: " + line), std::string::npos) << detect.err;
  EXPECT_EQ(Json::parse(detect.out)["unseen_pairs"], 1);
  const Json with_edges = json_of({"info", "edges.json", "--json"});
  EXPECT_EQ(with_edges["unseen_pairs_at_start"], 0);
  EXPECT_GT(with_edges["edge_contacts_at_start"], 0);
}

TEST_F(Info, SaysWhatWasDroppedReorientedAndUnreferenced) {
  write("odd.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n6\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 0\n9 9 "
        "9 0\n"
        "Triangles\n1\n1 2 3 0\nTetrahedra\n2\n1 2 3 4 0\n2 3 4 5 0\nEnd\n");
  const Json info = json_of({"info", "odd.mesh", "--json"});
  // det of (e2 - e1, e3 - e1, (1,1,1) - e1) is +2 for the second tet as written, so the first two are
  // oriented right; swapped corners are not.
  EXPECT_TRUE(info["reoriented_tets"].empty());
  EXPECT_EQ(info["dropped"], Json::parse(R"({"triangle": 1})"));
  EXPECT_EQ(info["unreferenced_points"], 1);
  EXPECT_EQ(info["points"], 6);
  EXPECT_EQ(info["upper"], Json::parse("[1, 1, 1]"));
  EXPECT_NE(output_of({"info", "odd.mesh"}).find("cells left out: 1 triangle; 1 point in no tet"),
            std::string::npos);

  write("inverted.mesh", one_tet(inverted_corner));
  EXPECT_EQ(json_of({"info", "inverted.mesh", "--json"})["reoriented_tets"], Json::parse("[0]"));
  EXPECT_NE(output_of({"info", "inverted.mesh"}).find("1 inverted tet re-oriented: 0"), std::string::npos);
}

TEST_F(Info, TellsPiecesAndWhereTheSurfaceIsNoManifold) {
  // Two tets that share an edge, and one of an eighth of their volume apart.
  write("three.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n10\n0 0 0 0\n0 0 1 0\n1 0 0 0\n0 1 0 0\n-1 0 0 0\n0 "
        "-1 0 0\n"
        "5 0 0 0\n5.5 0 0 0\n5 0.5 0 0\n5 0 0.5 0\nTetrahedra\n3\n1 3 4 2 0\n1 5 6 2 0\n7 8 9 10 0\nEnd\n");
  const Json info = json_of({"info", "three.mesh", "--json"});
  EXPECT_EQ(info["pieces"], 3);
  EXPECT_EQ(info["nonmanifold_edges"], 1);
  EXPECT_EQ(info["nonmanifold_points"], 0) << "at the ends of the edge the rings are connected by it";
  EXPECT_NE(output_of({"info", "three.mesh"})
                .find("pieces          3, the largest with 47.1 % of the volume; 1 edge and 0 points"),
            std::string::npos);
  // Two tets that share a point.
  write("two.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n7\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n-1 0 0 0\n0 "
        "-1 0 0\n"
        "0 0 -1 0\nTetrahedra\n2\n1 2 3 4 0\n1 5 7 6 0\nEnd\n");
  const Json touching = json_of({"info", "two.mesh", "--json"});
  EXPECT_EQ(touching["pieces"], 2);
  EXPECT_EQ(touching["nonmanifold_edges"], 0);
  EXPECT_EQ(touching["nonmanifold_points"], 1);
}

TEST_F(Info, TellsCellsThatWereCut) {
  write("cube.mesh",
        "MeshVersionFormatted 2\nDimension 3\nVertices\n8\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n0 0 1 0\n1 0 "
        "1 0\n"
        "1 1 1 0\n0 1 1 0\nHexahedra\n1\n1 2 3 4 5 6 7 8 0\nEnd\n");
  const Json info = json_of({"info", "cube.mesh", "--json"});
  EXPECT_EQ(info["converted"], Json::parse(R"({"hexahedron": {"cells": 1, "tets": 6}})"));
  EXPECT_NEAR(info["volume"].get<double>(), 1.0, 1e-15);
  EXPECT_NE(output_of({"info", "cube.mesh"}).find("1 hexahedron cells cut into 6 tets"), std::string::npos);
}

TEST_F(Info, TellsThatTheVolumeOfSolidCellsIsMissing) {
  const auto vtk = [](int type) {
    return "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n0 0 0 1 0 0 0 "
           "1 0 "
           "0 0 1 1 1 1\nCELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10\n" +
           std::to_string(type) + "\n";
  };
  write("convex.vtk", vtk(41));
  const Json info = json_of({"info", "convex.vtk", "--json"});
  EXPECT_EQ(info["dropped_solids"], 1);
  EXPECT_NEAR(info["volume"].get<double>(), 1.0 / 6.0, 1e-15);
  EXPECT_EQ(info["unreferenced_points"], 1);
  EXPECT_NE(output_of({"info", "convex.vtk"})
                .find("cells left out: 1 convex point set; volume is missing: that of 1 solid cell"),
            std::string::npos);
  write("bezier.vtk", vtk(78));
  EXPECT_EQ(json_of({"info", "bezier.vtk", "--json"})["dropped_solids"], 0);
  EXPECT_NEAR(json_of({"info", "bezier.vtk", "--json"})["volume"].get<double>(), 0.5, 1e-15)
      << "the second tet has twice the volume of the first";
}

TEST_F(Info, TakesAUnitAndGuessesOne) {
  const auto scaled = [&](const std::string& size) {
    return one_tet({"0 0 0", size + " 0 0", "0 " + size + " 0", "0 0 " + size});
  };
  write("large.mesh", scaled("190"));
  EXPECT_NE(output_of({"info", "large.mesh"}).find("likely unit     mm: 0.19 m long"), std::string::npos);
  EXPECT_EQ(json_of({"info", "large.mesh", "--json"})["likely_unit"], "mm");
  const std::string in_mm = output_of({"info", "large.mesh", "--unit", "mm"});
  EXPECT_NE(in_mm.find("max 268.7 mm"), std::string::npos) << in_mm;
  EXPECT_NE(in_mm.find("size            0.19 m long"), std::string::npos) << in_mm;
  const Finished wrong = palpate({"info", "large.mesh", "--unit", "m"});
  EXPECT_EQ(wrong.exit_code, 0);
  EXPECT_NE(wrong.err.find("'large.mesh' is 190 m long in m: is that its unit? In mm it is 0.19 m"),
            std::string::npos)
      << wrong.err;
  expect_error(2, {"info", "large.mesh", "--unit", "inch"}, {"--unit", "'inch'"});
}

TEST_F(Info, SceneTellsBodiesMassesObstaclesFixedPointsAndContacts) {
  write("tet.mesh", one_tet(inverted_corner));
  write("scene.json", R"({"units": {"length": "mm"}, "time_step": 0.02, "duration": 3, "gravity": [0, 0, 0],
    "rest": {"speed": 1, "time": 0.05}, "bodies": [
    {"name": "cube", "box": {"cells": [1, 1, 1], "size": [2, 2, 2]}, "obstacle": true},
    {"name": "tet", "mesh": "tet.mesh", "scale": 3, "translate": [0.5, 0.5, 0.5], "fixed": [{"points": [1, 2]}],
     "material": {"young_modulus": 10, "density": 2}}]})");
  const Json info = json_of({"info", "scene.json", "--json"});
  EXPECT_EQ(info["kind"], "scene");
  EXPECT_EQ(info["name"], "scene");
  EXPECT_EQ(info["units"]["length"], "mm");
  EXPECT_EQ(info["time_step"], 0.02);
  EXPECT_EQ(info["duration"], 3.0);
  EXPECT_EQ(info["edge_contacts_at_start"], 0);
  EXPECT_EQ(info["contacts_at_start"], 2) << "the tet's corner in the cube, the cube's corner in the tet";
  ASSERT_EQ(info["bodies"].size(), 2U);
  EXPECT_EQ(info["bodies"][0]["obstacle"], true);
  EXPECT_EQ(info["bodies"][1]["obstacle"], false);
  EXPECT_EQ(info["bodies"][1]["fixed_points"], 2);
  EXPECT_NEAR(info["bodies"][1]["mass"], 2.0 * 27.0 / 6.0, 1e-12);
  EXPECT_EQ(info["bodies"][1]["reoriented_tets"], Json::parse("[0]"));
  EXPECT_EQ(info["total"]["points"], 12);
  EXPECT_EQ(info["total"]["tets"], 6);

  const std::string text = output_of({"info", "scene.json"});
  for (const char* part :
       {"in mm, kg, s", "time step 0.02 s, duration 3 s", "obstacle", "2 points fixed",
        "1 inverted tet re-oriented", "contacts        2 at the start, of points; 0 of edges"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in:\n" << text;
  }
}

TEST_F(Info, RegionsCountInTheMass) {
  write("scene.json", R"({"bodies": [
    {"box": {"cells": [2, 1, 1], "size": [2, 1, 1]}, "material": {"density": 1},
     "regions": [{"box": {"lower": [0, -1, -1], "upper": [1, 1, 1]}, "material": {"density": 4}}]}]})");
  EXPECT_NEAR(json_of({"info", "scene.json", "--json"})["bodies"][0]["mass"], 1.0 + 4.0, 1e-12);
}

TEST_F(Info, RefusesWhatIsNoFileOfEitherKind) {
  expect_error(2, {"info", "missing.msh"}, {"missing.msh"});
  expect_error(2, {"info", "missing.json"}, {"missing.json"});
  expect_error(2, {"info", "noextension"}, {"noextension", "no extension", "'.vtu'", "'.json'"});
  expect_error(2, {"info", "mesh.vtx"}, {"mesh.vtx", ".vtx", "'.vtu'"});
  expect_error(2, {"info", "organ.stl"}, {"organ.stl", "a surface", "palpate mesh organ.stl"});
  expect_error(2, {"info", "map.nrrd"}, {"map.nrrd", "a label map", "palpate mesh map.nrrd"});
  expect_error(2, {"info", "map.nii.gz"}, {"map.nii.gz", "a label map", "palpate mesh map.nii.gz"});
  expect_error(2, {"info", "mesh.vtu.gz"}, {"mesh.vtu.gz", "the extension .gz", "'.vtu'"});
  std::filesystem::create_directory(folder_ / "folder.vtu");
  std::filesystem::create_directory(folder_ / "folder.json");
  expect_error(2, {"info", "folder.vtu"}, {"folder.vtu"});
  expect_error(2, {"info", "folder.json"}, {"folder.json"});
}

TEST_F(Info, SaysWhenItsOutputCannotBeWritten) {
  write("tet.mesh", one_tet(corner));
  const Finished finished = Process({"info", "tet.mesh"}, folder_.path(), "/dev/full").wait();
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_TRUE(finished.err.starts_with("palpate: error: stdout: writing: found 'No space left on device'"))
      << finished.err;
}

}  // namespace
}  // namespace palpate::test
