#include "mesh_program/conforming.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>

/// `palpate mesh --conforming`. Oracles: volumes of balls, faces matched bit by bit, Euler's formula, and
/// Dice by testing each voxel's centre against each tet.
namespace palpate::test {
namespace {

constexpr double inner_radius = 6.0;
constexpr double outer_radius = 10.0;

/// A ball (1) in a ball (2), voxels of 1 mm.
TestMap balls() {
  TestMap map({26, 26, 26}, [](int i, int j, int k) {
    const double r = std::sqrt((i - 12.4) * (i - 12.4) + (j - 12.6) * (j - 12.6) + (k - 12.5) * (k - 12.5));
    return r < inner_radius ? 1 : (r < outer_radius ? 2 : 0);
  });
  map.origin = {5, -40, 100};
  return map;
}

double ball_volume(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

std::string named(const TestMap& map) {
  return nrrd(map, "left-posterior-superior", segment(0, 1, "bulb", "1 1 1") + segment(1, 2, "fat", "1 1 0"));
}

double volume_of(const TetMesh& mesh) {
  double volume = 0.0;
  for (const Tet& t : mesh.tets) {
    std::array<Vec3, 4> p;
    for (std::size_t c = 0; c < 4; ++c) p[c] = mesh.points[static_cast<std::size_t>(t[c])];
    const double six = dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]);
    EXPECT_GT(six, 0.0);
    volume += six / 6.0;
  }
  return volume;
}

/// Points less edges plus faces of a closed surface: 2 for each ball.
long euler(const std::set<PlacedTriangle>& surface) {
  std::set<std::array<double, 3>> points;
  std::map<std::set<std::array<double, 3>>, int> edges;
  for (const PlacedTriangle& t : surface) {
    points.insert(t.begin(), t.end());
    for (std::size_t c = 0; c < 3; ++c) ++edges[{t[c], t[(c + 1) % 3]}];
  }
  for (const auto& [edge, triangles] : edges) EXPECT_EQ(triangles, 2) << "no manifold, or a point in an edge";
  return static_cast<long>(points.size()) - static_cast<long>(edges.size()) +
         static_cast<long>(surface.size());
}

bool holds(const TetMesh& mesh, const Tet& tet, const Vec3& place) {
  std::array<Vec3, 4> p;
  for (std::size_t c = 0; c < 4; ++c) p[c] = mesh.points[static_cast<std::size_t>(tet[c])];
  const auto side = [&](std::size_t a, std::size_t b, std::size_t c) {
    return dot(cross(p[b] - p[a], p[c] - p[a]), place - p[a]) <= 0.0;
  };
  return side(1, 2, 3) && side(0, 3, 2) && side(0, 1, 3) && side(0, 2, 1);
}

double dice_of(const TestMap& map, int label, const TetMesh& mesh) {
  std::size_t both = 0;
  std::size_t in_mesh = 0;
  for (int v = 0; v < static_cast<int>(map.labels.size()); ++v) {
    const int i = v % map.size[0];
    const int j = v / map.size[0] % map.size[1];
    const int k = v / (map.size[0] * map.size[1]);
    const Vec3 place = map.place(i, j, k);
    if (!std::ranges::any_of(mesh.tets, [&](const Tet& tet) { return holds(mesh, tet, place); })) continue;
    ++in_mesh;
    both += map.labels[static_cast<std::size_t>(v)] == label ? 1 : 0;
  }
  return 2.0 * static_cast<double>(both) / static_cast<double>(in_mesh + map.count(label));
}

TEST_F(Conforming, BodiesThatSlideHaveTheSameTrianglesAndNoGap) {
  write("balls.seg.nrrd", named(balls()));
  const Json report = conforming("balls.seg.nrrd", {"--relation", "bulb:fat=slides", "--tets", "4000"});
  const TetMesh bulb = mesh("bulb");
  const TetMesh fat = mesh("fat");
  EXPECT_NEAR(volume_of(bulb), ball_volume(inner_radius), 0.02 * ball_volume(inner_radius));
  const double shell = ball_volume(outer_radius) - ball_volume(inner_radius);
  EXPECT_NEAR(volume_of(fat), shell, 0.02 * shell);
  const auto inside = surface_of(bulb);
  const auto around = surface_of(fat);
  EXPECT_EQ(euler(inside), 2);
  EXPECT_EQ(euler(around), 4) << "two spheres";
  for (const PlacedTriangle& triangle : inside) EXPECT_TRUE(around.contains(turned(triangle)));
  // The rest of the outer surface is one sphere: there is no gap between the bodies.
  std::set<PlacedTriangle> rest = around;
  for (const PlacedTriangle& triangle : inside) rest.erase(turned(triangle));
  EXPECT_EQ(euler(rest), 2);
  EXPECT_EQ(surface_of(mesh("tissues")), rest) << "the whole mesh has the inner one as faces of two tets";
  EXPECT_EQ(report["interfaces"][0]["triangles"], inside.size());
  EXPECT_NEAR(report["tissues"][0]["dice"].get<double>(), dice_of(balls(), 1, bulb), 1e-12);
  EXPECT_NEAR(report["tissues"][1]["dice"].get<double>(), dice_of(balls(), 2, fat), 1e-12);
}

TEST_F(Conforming, ReportsWhatTheIssueAsksFor) {
  write("balls.seg.nrrd", named(balls()));
  const Json report = conforming("balls.seg.nrrd", {"--tets", "4000"});
  EXPECT_GE(report["min_dihedral_angle"].get<double>(), 8.0);
  EXPECT_GE(report["closed_fraction"].get<double>(), 0.99);
  EXPECT_NEAR(report["tets"].get<double>(), 4000, 400);
  for (const Json& tissue : report["tissues"]) {
    EXPECT_GE(tissue["dice"].get<double>(), 0.98) << tissue;
    EXPECT_EQ(tissue["lost_voxels"], 0);
    EXPECT_NEAR(tissue["volume"].get<double>(), tissue["input_volume"].get<double>(),
                0.01 * tissue["input_volume"].get<double>());
    EXPECT_LT(tissue["surface_distance"]["max"].get<double>(), 1.5);
  }
  EXPECT_EQ(report["warnings"], Json::array());
}

TEST_F(Conforming, TissuesThatAreGrownTogetherAreRegionsOfABodyThatRuns) {
  write("balls.seg.nrrd", named(balls()));
  const Json report = conforming("balls.seg.nrrd", {"--tets", "1500"});
  ASSERT_EQ(report["bodies"].size(), 1U);
  EXPECT_EQ(report["bodies"][0]["tissues"], Json({"bulb", "fat"}));
  const Json body = Json::parse(read("out/scene.json"))["bodies"][0];
  EXPECT_EQ(body["name"], "fat") << "the larger one";
  EXPECT_EQ(report["bodies"][0]["file"], "fat.vtu");
  EXPECT_EQ(body["regions"][0]["label"], 1) << "the bulb";
  output_of({"run", "out/scene.json", "--steps", "2", "--no-picture"});
  expect_error(2, {"info", "out/scene.json", "--set", "bodies[0].regions[0].label=7"},
               {"bodies[0].regions[0].label", "found 7", "a label of its tets: 1, 2"});
}

TEST_F(Conforming, SoftTissueIsGluedToBoneAtTheirCommonPoints) {
  write("balls.seg.nrrd", named(balls()));
  conforming("balls.seg.nrrd", {"--tets", "1500", "--rigid", "bulb"});
  const Json scene = Json::parse(read("out/scene.json"));
  EXPECT_EQ(scene["bodies"][0]["obstacle"], true);
  const Json attached = scene["bodies"][1]["attached"];
  ASSERT_EQ(attached.size(), 1U);
  EXPECT_EQ(attached[0]["to"], "bulb");
  std::set<std::array<double, 3>> of_bone;
  for (const PlacedTriangle& triangle : surface_of(mesh("bulb")))
    of_bone.insert(triangle.begin(), triangle.end());
  std::set<std::array<double, 3>> glued;
  const TetMesh fat = mesh("fat");
  for (const Json& index : attached[0]["points"]) {
    const Vec3& p = fat.points[index.get<std::size_t>()];
    glued.insert({p.x, p.y, p.z});
  }
  EXPECT_EQ(glued, of_bone);
  EXPECT_EQ(scene["bodies"][1]["no_contact"], Json({"bulb"}));
  output_of({"run", "out/scene.json", "--steps", "2", "--no-picture"});
  EXPECT_EQ(Json::parse(read("results/balls/run.json"))["contacts"]["largest"], 0);
}

TEST_F(Conforming, OpenTissuesHaveAGap) {
  write("balls.seg.nrrd", named(balls()));
  const Json report =
      conforming("balls.seg.nrrd", {"--relation", "bulb:fat=open", "--gap", "0.8", "--size", "1.5"});
  EXPECT_EQ(report["interfaces"][0]["triangles"], 0);
  const double radius = std::cbrt(volume_of(mesh("bulb")) / ball_volume(1.0));
  EXPECT_NEAR(radius, inner_radius - 0.4, 0.15) << "to a fraction of a voxel";
  const auto around = surface_of(mesh("fat"));
  for (const PlacedTriangle& triangle : surface_of(mesh("bulb")))
    EXPECT_FALSE(around.contains(turned(triangle)));
}

TEST_F(Conforming, OpenTissuesThatShareAPointAreNamed) {
  const TestMap map({24, 24, 24}, [](int i, int j, int k) {
    if (std::min({i, j, k}) < 2 || std::max({i, j, k}) > 21) return 0;
    return k < 12 ? 1 : 2;
  });
  write("two.nrrd", nrrd(map));
  const auto report = [&](const std::string& gap) {
    return conforming("two.nrrd", {"--relation", "open", "--gap", gap, "--size", "3"});
  };
  const Json narrow = report("1");
  EXPECT_EQ(narrow["interfaces"][0]["triangles"], 0);
  EXPECT_NE(narrow["warnings"].dump().find("label 1 and label 2 are open, but share"), std::string::npos);
  EXPECT_TRUE(narrow["closed_fraction"].is_null()) << "nothing is to be closed";
  EXPECT_EQ(report("2")["warnings"].dump().find("are open"), std::string::npos);
}

TEST_F(Conforming, LayersOfOneVoxelStayWhole) {
  // A flat sheet, and a shell of 1.5 voxels that meets the lattice at all angles.
  const TestMap map({24, 24, 24}, [](int i, int j, int k) {
    const double r = std::sqrt((i - 11.5) * (i - 11.5) + (j - 11.5) * (j - 11.5) + (k - 14.0) * (k - 14.0));
    if (i < 2 || j < 2 || i > 21 || j > 21 || k < 2 || k > 21) return 0;
    if (k == 4) return 1;
    return r >= 5.5 && r < 7.0 ? 2 : 3;
  });
  write("sheets.nrrd", nrrd(map));
  const Json report = conforming("sheets.nrrd", {"--relation", "slides", "--size", "4"});
  for (const Json& tissue : report["tissues"]) {
    EXPECT_EQ(tissue["lost_voxels"], 0) << tissue;
    EXPECT_NEAR(tissue["volume"].get<double>() / tissue["input_volume"].get<double>(), 1.0, 0.1) << tissue;
  }
  EXPECT_GE(report["closed_fraction"].get<double>(), 0.99);
  EXPECT_EQ(euler(surface_of(mesh("label-1"))), 2) << "a sheet without holes";
  EXPECT_EQ(euler(surface_of(mesh("label-2"))), 4) << "a shell without holes";
}

using PlacedEdge = std::array<std::array<double, 3>, 2>;

/// The edges around the common triangles of two bodies.
std::vector<PlacedEdge> rim_between(const TetMesh& a, const TetMesh& b) {
  const auto of_b = surface_of(b);
  std::map<PlacedEdge, int> edges;
  for (const PlacedTriangle& triangle : surface_of(a)) {
    if (!of_b.contains(turned(triangle))) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& [low, high] = std::minmax(triangle[c], triangle[(c + 1) % 3]);
      ++edges[{low, high}];
    }
  }
  std::vector<PlacedEdge> rim;
  for (const auto& [edge, triangles] : edges) {
    if (triangles == 1) rim.push_back(edge);
  }
  return rim;
}

Vec3 vector_of(const std::array<double, 3>& p) {
  return {p[0], p[1], p[2]};
}

double length_of(const std::vector<PlacedEdge>& edges) {
  double sum = 0.0;
  for (const auto& [a, b] : edges) sum += length(vector_of(b) - vector_of(a));
  return sum;
}

TEST_F(Conforming, EdgesFollowTheCircleWhereThreeTissuesMeet) {
  // A ball cut by an oblique plane: two tissues and the outside meet in a circle.
  constexpr double radius = 14.0;
  constexpr double height = 2.3;
  const Vec3 center{19.5, 19.5, 19.5};
  const Vec3 normal{0.8, 0.36, 0.48};
  const TestMap map({40, 40, 40}, [&](int i, int j, int k) {
    const Vec3 p = Vec3{1.0 * i, 1.0 * j, 1.0 * k} - center;
    if (length(p) >= radius) return 0;
    return dot(p, normal) < height ? 1 : 2;
  });
  write("halves.nrrd", nrrd(map));
  const Json report = conforming("halves.nrrd", {"--size", "4", "--relation", "slides"});
  const auto rim = rim_between(mesh("label-1"), mesh("label-2"));
  const double of_circle = std::sqrt(radius * radius - height * height);
  std::map<std::array<double, 3>, int> ends;
  double off = 0.0;
  for (const PlacedEdge& edge : rim) {
    for (const auto& end : edge) {
      ++ends[end];
      const Vec3 p = vector_of(end) - center;
      const double up = dot(p, normal) / length(normal);
      off = std::max(off, std::hypot(up - height, std::sqrt(squared_length(p) - up * up) - of_circle));
    }
  }
  for (const auto& [end, edges] : ends) EXPECT_EQ(edges, 2) << "a closed line";
  EXPECT_LT(off, 1.0) << "a voxel";
  EXPECT_NEAR(length_of(rim), 2.0 * std::numbers::pi * of_circle, 0.04 * 2.0 * std::numbers::pi * of_circle)
      << "a jagged line is longer";
  EXPECT_LT(report["line_distance"]["mean"].get<double>(), 0.3);
}

TEST_F(Conforming, EdgesFollowLinesThatMeetInAPoint) {
  // A ball in three sectors: an axis and three half circles, which meet at both poles, where four tissues do.
  constexpr double radius = 13.0;
  const TestMap map({34, 34, 34}, [](int i, int j, int k) {
    const Vec3 p{i - 16.3, j - 16.6, k - 16.4};
    if (length(p) >= radius) return 0;
    const double angle = std::atan2(p.y + 0.3 * p.z, p.x + 0.2 * p.z) + std::numbers::pi;
    return 1 + std::min(2, static_cast<int>(angle / (2.0 * std::numbers::pi / 3.0)));
  });
  write("sectors.nrrd", nrrd(map));
  conforming("sectors.nrrd", {"--size", "4", "--relation", "slides"});
  const std::array<TetMesh, 3> sectors{mesh("label-1"), mesh("label-2"), mesh("label-3")};
  for (std::size_t s = 0; s < 3; ++s) {
    const double length = length_of(rim_between(sectors[s], sectors[(s + 1) % 3]));
    const double wanted = (2.0 + std::numbers::pi) * radius;
    EXPECT_NEAR(length, wanted, 0.06 * wanted);
  }
}

TEST_F(Conforming, LinesThatAreTooNearToEachOtherAreLeftOut) {
  const TestMap map({20, 20, 20}, [](int i, int j, int k) {
    if (std::min({i, j, k}) < 2 || std::max({i, j, k}) > 17) return 0;
    const unsigned hash = (static_cast<unsigned>(i / 2) * 73856093U) ^
                          (static_cast<unsigned>(j / 2) * 19349663U) ^
                          (static_cast<unsigned>(k / 2) * 83492791U);
    return 1 + static_cast<int>(hash / 7U % 4U);
  });
  write("noise.nrrd", nrrd(map));
  const Json report = conforming("noise.nrrd", {"--size", "3"});
  EXPECT_GT(report["closed_fraction"].get<double>(), 0.9);
  const TetMesh tissues = mesh("tissues");
  double shortest = 1.0;
  for (const Tet& t : tissues.tets) {
    for (std::size_t c = 0; c < 4; ++c) {
      const auto& [a, b] = std::pair(tissues.points[static_cast<std::size_t>(t[c])],
                                     tissues.points[static_cast<std::size_t>(t[(c + 1) % 4])]);
      shortest = std::min(shortest, length(b - a));
    }
  }
  EXPECT_GT(shortest, 0.1) << "ends of lines that nearly touch";
  double sum = 0.0;
  for (const Json& tissue : report["tissues"]) sum += tissue["volume"].get<double>();
  EXPECT_NEAR(sum, 16.0 * 16.0 * 16.0, 0.05 * 16.0 * 16.0 * 16.0);
}

TEST_F(Conforming, TheSameMapGivesTheSameBytes) {
  write("balls.seg.nrrd", named(balls()));
  conforming("balls.seg.nrrd", {"--size", "2.5"});
  const std::string first = read("out/tissues.vtu") + read("out/scene.json");
  conforming("balls.seg.nrrd", {"--size", "2.5"});
  EXPECT_EQ(read("out/tissues.vtu") + read("out/scene.json"), first);
}

TEST_F(Conforming, SizesOfAnInterfaceAndInAFocus) {
  write("balls.seg.nrrd", named(balls()));
  const auto triangles = [&](std::vector<std::string> flags) {
    flags.insert(flags.end(), {"--size", "4"});
    return conforming("balls.seg.nrrd", flags)["interfaces"][0]["triangles"].get<int>();
  };
  const int coarse = triangles({});
  EXPECT_GT(triangles({"--size", "bulb:fat=1"}), 2 * coarse);
  // Half of the inner ball, by its place in the world: centre (17.4, -27.4, 112.5).
  const int focused = triangles({"--focus", "23.4,-27.4,112.5,6=0.8"});
  EXPECT_GT(focused, 1.2 * coarse);
  EXPECT_LT(
      conforming("balls.seg.nrrd", {"--size", "4", "--focus", "200,0,0,6=0.8"})["interfaces"][0]["triangles"],
      focused);
}

/// The label map that every user can make, coarse.
TEST_F(Conforming, TheEyeOfOurShapesRuns) {
  output_of({"generate", "eye-labels", "--voxel", "2", "--out", "eye.seg.nrrd"});
  const Json report =
      conforming("eye.seg.nrrd", {"--rigid", "bone", "--relation", "slides", "--tets", "12000"});
  EXPECT_EQ(report["bodies"].size(), 9U);
  EXPECT_GE(report["closed_fraction"].get<double>(), 0.99);
  EXPECT_GE(report["min_dihedral_angle"].get<double>(), 8.0);
  output_of({"run", "out/scene.json", "--steps", "2", "--no-picture"});
  EXPECT_EQ(Json::parse(read("results/eye/run.json"))["bodies"].size(), 9U);
}

TEST_F(Conforming, ALayerOfOneVoxelWithoutNeighboursIsMeshedOrNamed) {
  const TestMap map({24, 24, 24}, [](int i, int j, int k) {
    return k == 12 && i > 2 && i < 21 && j > 2 && j < 21 ? 1 : 0;
  });
  write("sheet.nrrd", nrrd(map));
  for (const std::vector<std::string>& flags :
       {std::vector<std::string>{"--size", "10"}, {"--tets", "3000"}}) {
    const Json report = conforming("sheet.nrrd", flags);
    EXPECT_EQ(report["tissues"][0]["lost_voxels"], 0);
    EXPECT_EQ(euler(surface_of(mesh("label-1"))), 2) << "a sheet without holes";
    if (flags[0] == "--tets") {
      EXPECT_NEAR(report["tets"].get<double>(), 3000, 300);
    }
  }
  expect_error(2, {"mesh", "sheet.nrrd", "--conforming", "--quiet", "--size", "100"},
               {"label 1: found no tet at size 1.2 mm", "a smaller --size"});
}

TEST_F(Conforming, WarnsOfLabelsThatAreCutOrScattered) {
  const TestMap map({14, 14, 14}, [](int i, int j, int k) {
    if (i == 11 && j == 11 && k == 11) return 2;
    if (i == 9 && j == 3 && k == 11) return 1;
    return i < 7 && j > 2 && j < 11 && k > 2 && k < 9 ? 1 : 0;
  });
  write("cut.nrrd", nrrd(map));
  const std::string warnings = conforming("cut.nrrd", {"--size", "2"})["warnings"].dump();
  EXPECT_NE(warnings.find("label 1: touches the border of the map"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("label 1: 2 parts; 1 voxel is not in the largest"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("label 2: only 1 voxel"), std::string::npos) << warnings;
}

TEST_F(Conforming, WarnsWhereTheNumberOfTetsIsMissed) {
  write("balls.seg.nrrd", named(balls()));
  const Json report = conforming("balls.seg.nrrd", {"--tets", "5"});
  const std::string words = report["tets"].dump() + " tets, where 5 were asked for";
  EXPECT_NE(report["warnings"].dump().find(words), std::string::npos) << report["warnings"];
  EXPECT_EQ(conforming("balls.seg.nrrd", {"--tets", "4000"})["warnings"].dump().find("asked for"),
            std::string::npos);
}

TEST_F(Conforming, WarnsOfATissueThatLosesVolume) {
  const TestMap map({30, 30, 30}, [](int i, int j, int k) {  // a rod on the interface of two blocks
    if (std::min({i, j, k}) < 3 || std::max({i, j, k}) > 26) return 0;
    if ((i == 14 || i == 15) && (j == 14 || j == 15)) return 3;
    return i < 15 ? 1 : 2;
  });
  write("rod.nrrd", nrrd(map));
  const Json report = conforming("rod.nrrd", {"--size", "3"});
  const Json& rod = report["tissues"][2];
  EXPECT_NEAR(rod["volume"].get<double>() / rod["input_volume"].get<double>(), 1.0, 0.1);
  EXPECT_EQ(report["warnings"].size(), 0U) << report["warnings"];
  const Json coarse = conforming("rod.nrrd", {"--tets", "300"});
  EXPECT_NE(coarse["warnings"].dump().find("% of the volume of its voxels"), std::string::npos);
}

TEST_F(Conforming, NoTissuesMeetAcrossAThinObliqueLayer) {
  // Three layers, the middle one 1.15 or 0.58 voxels thick. An edge between two voxel centres jumps over it.
  for (const int voxels : {2, 1}) {
    const TestMap map({16, 16, 16}, [&](int i, int j, int k) {
      if (std::min({i, j, k}) < 2 || std::max({i, j, k}) > 13) return 0;
      const int up = i + j + k;
      return up < 22 ? 1 : up < 22 + voxels ? 2 : 3;
    });
    write("layer.nrrd", nrrd(map));
    const Json report = conforming("layer.nrrd", {"--size", "4"});
    EXPECT_LT(report["line_distance"]["max"].get<double>(), 1.5) << "its lines are at the outside";
    for (const Json& tissue : report["tissues"]) {
      EXPECT_NEAR(tissue["volume"].get<double>() / tissue["input_volume"].get<double>(), 1.0, 0.1);
      EXPECT_EQ(tissue["lost_voxels"], 0);
    }
  }
}

TEST_F(Conforming, LinesOfOneTissueHaveNoDistance) {
  write("ball.nrrd", nrrd(TestMap({20, 20, 20}, [](int i, int j, int k) {
          return std::hypot(i - 9.5, j - 9.5, k - 9.5) < 7.0 ? 1 : 0;
        })));
  EXPECT_TRUE(conforming("ball.nrrd", {"--size", "4"})["line_distance"].is_null());
}

TEST_F(Conforming, WarnsOfAFocusOutsideOfTheTissues) {
  write("balls.seg.nrrd", named(balls()));
  const auto warnings = [&](const std::string& focus) {
    return conforming("balls.seg.nrrd", {"--size", "4", "--focus", focus})["warnings"].dump();
  };
  EXPECT_NE(warnings("900,900,900,5=1").find("--focus number 1 does not reach the mesh"), std::string::npos);
}

TEST_F(Conforming, RefusesWhatDoesNotFit) {
  write("balls.seg.nrrd", named(balls()));
  write("box.stl", box_stl({0, 0, 0}, {1, 1, 1}));
  const auto refuse = [&](std::vector<std::string> flags, const std::vector<std::string>& parts) {
    flags.insert(flags.begin(), "mesh");
    expect_error(2, std::move(flags), parts);
  };
  refuse({"box.stl", "--conforming"}, {"--conforming", "surfaces", "a label map"});
  const std::string map = "balls.seg.nrrd";
  refuse({map, "--relation", "slides"}, {"--relation", "without --conforming"});
  refuse({map, "--conforming", "--relation", "glued"}, {"--relation", "'glued'", "slides"});
  refuse({map, "--conforming", "--relation", "bulb:bone=slides"}, {"--relation", "'bulb:bone'", "bulb, fat"});
  refuse({map, "--conforming", "--relation", "open"}, {"'open' without --gap"});
  refuse({map, "--conforming", "--gap", "1"}, {"--gap", "--relation"});
  refuse({map, "--conforming", "--tets", "fat=100"}, {"--tets", "--size ORGAN=MM"});
  refuse({map, "--conforming", "--size", "fat:skin=1"}, {"--size", "'fat:skin'"});
  refuse({map, "--conforming", "--focus", "1,2,3=4"}, {"--focus", "X,Y,Z,RADIUS=MM"});
  write("bent.nrrd",
        "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
        "space directions: (1,0,0) (1,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n\n1 1 1 1 1 1 1 "
        "1\n");
  refuse({"bent.nrrd", "--conforming"}, {"bent.nrrd", "right angles"});
  write("long.mha",
        "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementSpacing = 1 1 1\nTransformMatrix = 2 0 0 0 2 "
        "0 0 0 2\n"
        "Offset = 0 0 0\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
            std::string(8, '\1'));
  refuse({"long.mha", "--conforming"}, {"long.mha", "a direction of length 2", "spacing"});
  std::string stretched = nifti(balls());
  const float longer = 2.5F;
  std::memcpy(stretched.data() + 280, &longer, sizeof longer);  // srow_x[0], where pixdim says 1
  write("stretched.nii", stretched);
  refuse({"stretched.nii", "--conforming"}, {"stretched.nii", "unit vectors", "pixdim"});
  write("series.nrrd",
        "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 2 2 2\nkinds: domain domain domain time\n"
        "encoding: ascii\n\n0 1 0 1 0 1 0 1 0 1 0 1 0 1 0 1\n");
  refuse({"series.nrrd", "--conforming"}, {"series.nrrd", "4 dimensions", "three"});
}

TEST_F(Conforming, RefusesRelationsThatContradictEachOther) {
  const TestMap map({16, 16, 16}, [](int i, int j, int k) {
    if (k < 2 || k > 13 || i < 2 || i > 13 || j < 2 || j > 13) return 0;
    return i < 8 ? 1 : (j < 8 ? 2 : 3);
  });
  write("three.nrrd", nrrd(map));
  expect_error(2,
               {"mesh", "three.nrrd", "--conforming", "--quiet", "--size", "3", "--relation", "1:2=slides"},
               {"label 1:label 2", "'slides'", "grown together through others"});
  expect_error(2,
               {"mesh", "three.nrrd", "--conforming", "--quiet", "--size", "3", "--max-points", "10",
                "--relation", "1:2=slides"},
               {"'slides'", "grown together through others"});  // not that there are too many points
  const Json report = conforming("three.nrrd", {"--size", "3", "--relation", "1=slides"});
  ASSERT_EQ(report["bodies"].size(), 2U) << "nothing else contradicts: 2 and 3 are grown together";
  EXPECT_EQ(report["bodies"][1]["tissues"], Json({"label 2", "label 3"}));
}

}  // namespace
}  // namespace palpate::test
