// A simulation with a viewer that pulls and changes it. Oracles: the same simulation without a viewer (bits),
// Hooke's law, the path of a motion.
#include "view/live.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "view/colour_field.hpp"
#include "view/frame.hpp"
#include "view/messages.hpp"
#include "view/scenes.hpp"

namespace palpate::view {
namespace {

/// The highest vertex of a body.
Index top_of(const LiveSource& source, const Surface& surface, std::size_t body) {
  Index top = surface.body_vertices()[body].begin;
  const auto height = [&](Index v) { return at(source.positions(), at(surface.points(), v)).z; };
  for (Index v = top; v < surface.body_vertices()[body].end; ++v) {
    if (height(v) > height(top)) top = v;
  }
  return top;
}

TEST(LiveSource, HasTheBitsOfARunThatNobodyLooksAt) {
  const Scene scene = test::small_scene();
  Simulation alone(test::small_model(scene), scene.settings, 1);
  const auto source = test::small_source();
  const Surface surface(source->bodies());
  for (int i = 0; i < 20; ++i) {
    alone.step();
    source->advance();
    static_cast<void>(frame_message(*source, surface, {true, true, true}, {}));
  }
  EXPECT_EQ(source->simulation().state_hash(), alone.state_hash());
  source->reset();
  EXPECT_EQ(source->time(), 0.0);
  test::run(*source, 20);
  EXPECT_EQ(source->simulation().state_hash(), alone.state_hash()) << "a reset begins the same run again";
}

TEST(LiveSource, HasOneNumberAPointOfEachField) {
  const auto source = test::small_source();
  test::run(*source, 5);
  const TissueState tissue = source->simulation().tissue_at_points();
  std::vector<std::string> names;
  for (const auto& field : source->stage().about["fields"]) {
    names.push_back(field["name"]);
    EXPECT_EQ(source->field(names.back()).size(), source->positions().size()) << names.back();
  }
  for (const char* name :
       {"von_mises", "contact_force", "strain_xy", "plastic_strain_zz", "principal_stress_1"})
    EXPECT_EQ(std::ranges::count(names, name), 1) << name;
  EXPECT_EQ(std::ranges::count(names, "stress"), 0) << "six numbers are no colour";
  EXPECT_EQ(std::ranges::count(names, "deformation_gradient"), 0);
  EXPECT_TRUE(source->field("stress").empty());
  for (const FieldInfo& info : field_infos()) {
    EXPECT_TRUE(std::ranges::any_of(names,
                                    [&](const std::string& name) {
                                      return name.starts_with(info.name) &&
                                             find_colour_field(name)->info == &info;
                                    }))
        << "every field can be shown: " << info.name;
  }
  const std::vector<double> first = source->field("principal_stress_1");
  const std::vector<double> third = source->field("principal_stress_3");
  const std::vector<double> xx = source->field("stress_xx");
  const std::vector<double> yy = source->field("stress_yy");
  const std::vector<double> zz = source->field("stress_zz");
  std::size_t compared = 0;
  for (std::size_t p = 0; p < first.size(); ++p) {
    if (std::isnan(tissue.pressure[p])) continue;
    EXPECT_GE(first[p], third[p]);
    EXPECT_NEAR(xx[p] + yy[p] + zz[p], -3.0 * tissue.pressure[p],
                1e-9 * (1.0 + std::abs(tissue.pressure[p])));
    EXPECT_LE(zz[p], first[p] + 1e-9 * (1.0 + std::abs(first[p]))) << "no direction has more than the first";
    ++compared;
  }
  EXPECT_GT(compared, 8U);
}

TEST(LiveSource, ShowsTheNineNumbersOfATensorOneByOne) {
  const auto source = test::small_source();
  test::run(*source, 5);
  const Simulation& simulation = source->simulation();
  const TissueState tissue = simulation.tissue_at_points();
  constexpr std::array axes{"x", "y", "z"};
  double sheared = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::vector<double> gradient =
          source->field(std::string("deformation_gradient_") + axes[i] + axes[j]);
      ASSERT_EQ(gradient.size(), tissue.size());
      for (std::size_t p = 0; p < gradient.size(); ++p) {
        EXPECT_EQ(gradient[p], tissue.deformation_gradient[p][3 * i + j]) << i << j << " of point " << p;
        if (i != j) sheared = std::max(sheared, std::abs(gradient[p]));
      }
    }
  }
  EXPECT_GT(sheared, 0.0);
  std::size_t compared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name = "principal_directions_" + std::to_string(k + 1);
    const std::vector<double> x = source->field(name + "x");
    const std::vector<double> y = source->field(name + "y");
    const std::vector<double> z = source->field(name + "z");
    const std::vector<double> sizes = source->field("principal_stress_" + std::to_string(k + 1));
    for (std::size_t p = 0; p < x.size(); ++p) {
      const SymmetricTensor& s = tissue.stress[p];
      if (std::isnan(s.xx) || tissue.von_mises[p] == 0.0) continue;
      // S v = lambda v
      const double scale = 1e-9 * (std::abs(sizes[p]) + tissue.von_mises[p]);
      EXPECT_NEAR(s.xx * x[p] + s.xy * y[p] + s.xz * z[p], sizes[p] * x[p], scale)
          << name << " of point " << p;
      EXPECT_NEAR(s.xy * x[p] + s.yy * y[p] + s.yz * z[p], sizes[p] * y[p], scale)
          << name << " of point " << p;
      EXPECT_NEAR(s.xz * x[p] + s.yz * y[p] + s.zz * z[p], sizes[p] * z[p], scale)
          << name << " of point " << p;
      EXPECT_NEAR(x[p] * x[p] + y[p] * y[p] + z[p] * z[p], 1.0, 1e-9);
      ++compared;
    }
  }
  EXPECT_GT(compared, 24U);
}

TEST(LiveSource, ShowsReactionsOfHeldPoints) {
  const auto source = test::small_source();
  EXPECT_EQ(source->field("reaction"), std::vector<double>(source->positions().size(), 0.0))
      << "at the start";
  test::run(*source, 5);
  const std::vector<double> sizes = source->field("reaction");
  const std::span<const Vec3> reactions = source->simulation().reactions();
  ASSERT_EQ(sizes.size(), reactions.size());
  double most = 0.0;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    EXPECT_NEAR(sizes[p], length(reactions[p]), 1e-12 * length(reactions[p])) << p;
    most = std::max(most, sizes[p]);
  }
  EXPECT_GT(most, 0.0);
}

TEST(LiveSource, SendsTheSurfaceAsItIs) {
  const auto source = test::small_source();
  test::run(*source, 5);
  const Surface surface(source->bodies());
  const test::Read stage = test::read_message(stage_message(*source, surface));
  const test::Read frame = test::read_message(frame_message(*source, surface, {true, true, true}, {}));
  const auto& positions = frame.floats.at("positions");
  ASSERT_EQ(positions.size(), 3 * surface.points().size());
  const Vec3 origin = source->stage().origin;
  for (std::size_t v = 0; v < surface.points().size(); ++v) {
    const Vec3 p = at(source->positions(), surface.points()[v]) - origin;
    EXPECT_EQ(positions[3 * v], static_cast<float>(p.x));
    EXPECT_EQ(positions[3 * v + 1], static_cast<float>(p.y));
    EXPECT_EQ(positions[3 * v + 2], static_cast<float>(p.z));
  }
  // 4 x 4 x 4 points of the box, of which 2 x 2 x 2 are inside; the plate and the press are all surface.
  EXPECT_EQ(surface.points().size(), 18U + 56U + 8U);
  EXPECT_EQ(stage.integers.at("triangles").size(), 3 * source->bodies().triangles().size());
  const Contacts& contacts = source->detector().contacts();
  ASSERT_GT(contacts.size(), 0U);
  ASSERT_EQ(frame.floats.at("contacts").size(), 7 * contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_EQ(frame.floats.at("contacts")[7 * c + 6], static_cast<float>(contacts.depth[c]));
    EXPECT_EQ(frame.integers.at("contact_places")[3 * c], surface.vertex_of(contacts.point[c]));
    EXPECT_EQ(frame.integers.at("contact_places")[3 * c + 1],
              source->bodies().body_of_point()[static_cast<std::size_t>(contacts.point[c])]);
    EXPECT_EQ(frame.integers.at("contact_places")[3 * c + 2], contacts.body[c]);
  }
  EXPECT_EQ(frame.floats.at("border_edges").size(), 6 * source->detector().border_edges().size());
  EXPECT_EQ(frame.floats.at("crossings").size(), 3 * source->detector().crossings().size());
  // Each point is in one of the cells.
  const CellDomain domain = source->detector().cell_domain();
  const auto& cells = frame.floats.at("cells");
  for (const Vec3& point : source->positions()) {
    const Vec3 p = point - origin;
    bool found = false;
    for (std::size_t c = 0; c < cells.size(); c += 3) {
      const double slack = 1e-5;
      found = found || (p.x > cells[c] - slack && p.x < cells[c] + domain.cell_size + slack &&
                        p.y > cells[c + 1] - slack && p.y < cells[c + 1] + domain.cell_size + slack &&
                        p.z > cells[c + 2] - slack && p.z < cells[c + 2] + domain.cell_size + slack);
    }
    EXPECT_TRUE(found);
  }
}

TEST(LiveSource, SendsTheInsideWhereItIsAskedFor) {
  const auto source = test::small_source();
  test::run(*source, 5);
  const Surface surface(source->bodies());
  const test::Read stage = test::read_message(stage_message(*source, surface));
  const test::Read without =
      test::read_message(frame_message(*source, surface, {.fields = {"von_mises"}}, {}));
  EXPECT_FALSE(without.floats.contains("inner"));
  const test::Read frame =
      test::read_message(frame_message(*source, surface, {.inside = true, .fields = {"von_mises"}}, {}));
  const auto& vertices = frame.floats.at("positions");
  const auto& inner = frame.floats.at("inner");
  ASSERT_EQ(inner.size(), 3U * 8U) << "4 x 4 x 4 points of the box, of which 2 x 2 x 2 are inside";
  EXPECT_EQ(stage.floats.at("inner_rest").size(), inner.size());
  ASSERT_EQ(frame.floats.at("von_mises").size(), (vertices.size() + inner.size()) / 3);
  ASSERT_EQ(without.floats.at("von_mises").size(), vertices.size() / 3);
  // The tets of the bodies again, from what was sent.
  const std::vector<double> stress = point_scalars(source->simulation(), "von_mises");
  const auto& corners = stage.integers.at("tets");
  ASSERT_EQ(corners.size(), 4 * source->bodies().tets().size());
  const Vec3 origin = source->stage().origin;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const auto corner = static_cast<std::size_t>(corners[c]);
    const std::size_t count = vertices.size() / 3;
    const float* const sent = corner < count ? &vertices[3 * corner] : &inner[3 * (corner - count)];
    const auto point = static_cast<std::size_t>(source->bodies().tets()[c / 4][c % 4]);
    const Vec3 p = source->positions()[point] - origin;
    EXPECT_EQ(sent[0], static_cast<float>(p.x));
    EXPECT_EQ(sent[1], static_cast<float>(p.y));
    EXPECT_EQ(sent[2], static_cast<float>(p.z));
    const auto value = static_cast<float>(stress[point]);
    const float shown = frame.floats.at("von_mises")[corner];
    EXPECT_TRUE(shown == value || (std::isnan(shown) && std::isnan(value))) << shown << " " << value;
  }
}

TEST(LiveSource, SendsTheColoursOfPictures) {
  const auto source = test::small_source();
  const test::Read stage = test::read_message(stage_message(*source, Surface(source->bodies())));
  const std::vector<double> grey{0.72, 0.72, 0.74};
  const std::vector<double> orange{0.93, 0.65, 0.15};  // the second one of pictures
  for (const auto& body : stage.header.at("bodies"))
    EXPECT_EQ(body.at("color"), body.at("name") == "box" ? orange : grey) << body;
}

TEST(LiveSource, SendsContactsOfEdges) {
  const Scene scene = test::crossed_bars();
  LiveSource source(scene, test::small_model(scene), 1);
  const Surface surface(source.bodies());
  const test::Read frame = test::read_message(frame_message(source, surface, {true, false, false}, {}));
  EXPECT_TRUE(frame.floats.at("contacts").empty());
  const auto& contacts = frame.floats.at("edge_contacts");
  const auto& places = frame.integers.at("edge_contact_places");
  ASSERT_GE(contacts.size(), 7U * 4U) << "two long edges of each bar, and what crosses its face";
  ASSERT_EQ(places.size() / 3, contacts.size() / 7);
  const Vec3 origin = source.stage().origin;
  for (std::size_t c = 0; c < contacts.size() / 7; ++c) {
    const float* const row = &contacts[7 * c];
    EXPECT_NEAR(row[6], 0.001F, 1e-6F);
    const bool of_upper = places[3 * c + 1] == 1;
    EXPECT_EQ(places[3 * c], -1);
    EXPECT_EQ(places[3 * c + 2], of_upper ? 0 : 1);
    EXPECT_NEAR(row[5], of_upper ? 1.0F : -1.0F, 1e-5F);
    EXPECT_NEAR(row[2] + origin.z, of_upper ? 0.009 : 0.01, 1e-6);
    EXPECT_LE(std::abs(row[0] + origin.x - 0.003), 0.01 + 1e-6) << "where the bars cross";
    EXPECT_LE(std::abs(row[1] + origin.y), 0.01 + 1e-6);
  }
}

TEST(LiveSource, APullMovesTissueByHookesLawAndLetsItGo) {
  const auto source = test::small_source();
  const Surface surface(source->bodies());
  test::run(*source, 40);
  const Index vertex = top_of(*source, surface, 1);
  const Index point = at(surface.points(), vertex);
  const Vec3 before = at(source->positions(), point);
  const Vec3 target = before + Vec3{0, 0, 0.001};  // below the limit of a corner
  source->apply(1, Pull{vertex, target - source->stage().origin, 1.0});
  test::run(*source, 150);
  const Vec3 pulled = at(source->positions(), point);
  EXPECT_GT(pulled.z, before.z + 0.0001);
  const auto pulls = source->counts()["pulls"];
  ASSERT_EQ(pulls.size(), 1U);
  const double force = pulls[0]["force"][2];
  const double stiffness =
      20000 * mesh_statistics(source->bodies(), source->bodies().points_rest(), 1).edge_length.mean;
  EXPECT_NEAR(force, stiffness * (target.z - pulled.z), 0.02 * force);
  source->apply(1, LetGo{});
  EXPECT_TRUE(source->counts()["pulls"].empty());
  test::run(*source, 150);
  EXPECT_NEAR(at(source->positions(), point).z, before.z, 0.00005);
}

TEST(LiveSource, EachPageHoldsOnePullAndLosesItWhenItGoes) {
  const auto source = test::small_source();
  const Surface surface(source->bodies());
  const Index vertex = top_of(*source, surface, 1);
  source->apply(1, Pull{vertex, {}, 1.0});
  source->apply(2, Pull{vertex, {}, 1.0});
  source->apply(2, Pull{vertex, {}, 2.0});
  EXPECT_EQ(source->counts()["pulls"].size(), 2U);
  source->forget(2);
  EXPECT_EQ(source->counts()["pulls"].size(), 1U);
  source->reset();
  EXPECT_TRUE(source->counts()["pulls"].empty());
  EXPECT_NO_THROW(source->apply(1, MovePull{{1, 1, 1}})) << "a reset may come while a page drags";
}

TEST(LiveSource, RefusesWhatCannotBePulled) {
  const auto source = test::small_source();
  const Surface surface(source->bodies());
  EXPECT_THROW(source->apply(1, Pull{surface.vertex_count(), {}, 1.0}), Error);
  EXPECT_THROW(source->apply(1, Pull{-1, {}, 1.0}), Error);
  EXPECT_THROW(source->apply(1, Pull{0, {}, 1.0}), Error) << "of the plate";
  EXPECT_THROW(source->apply(1, Pull{top_of(*source, surface, 2), {}, 1.0}), Error) << "prescribed";
  EXPECT_THROW(source->apply(1, DriveMotion{1, 0.5, {}}), Error);
  EXPECT_THROW(source->apply(1, Seek{0}), Error);
  EXPECT_TRUE(source->counts()["pulls"].empty());
}

TEST(LiveSource, MovesPrescribedBodiesOnAndOffTheirPath) {
  const auto source = test::small_source();
  const Index corner = at(source->bodies().bodies(), 2).points.begin;
  const Vec3 start = at(source->positions(), corner);
  const auto press = [&] { return at(source->positions(), corner) - start; };
  source->apply(1, DriveMotion{0, 0.5, {}});
  source->advance();
  EXPECT_LE(length(press()), 0.01 * 4 * 0.01 + 1e-12) << "four times as fast as the path at most";
  test::run(*source, 40);
  EXPECT_NEAR(press().z, -0.005, 1e-12);
  EXPECT_EQ(source->counts()["driven"][0]["held"], true);
  source->apply(1, DriveMotion{0, {}, Vec3{0.02, 0, 0}});
  test::run(*source, 40);
  EXPECT_NEAR(press().x, 0.02, 1e-12);
  EXPECT_NEAR(press().z, -0.005, 1e-12);
  source->apply(1, ResumeMotion{0});
  test::run(*source, 10);
  EXPECT_NEAR(press().z, -0.006, 1e-12) << "from where it is on its path, by itself";
  test::run(*source, 100);
  EXPECT_NEAR(press().x, 0.0, 1e-12);
  EXPECT_NEAR(press().z, -0.01, 1e-12);
}

TEST(LiveSource, CountsStepsThatDidNotConvergeAndTetsInsideOut) {
  Scene scene = test::small_scene();
  scene.settings.solver.preconditioner = Preconditioner::jacobi;
  scene.settings.solver.max_iterations = 1;
  LiveSource source(scene, test::small_model(scene), 1);
  EXPECT_EQ(source.counts()["steps_not_converged"], 0);
  int bad = 0;
  for (int i = 0; i < 10; ++i) {
    source.advance();
    bad += source.simulation().metrics().solver_converged ? 0 : 1;
  }
  EXPECT_GT(bad, 0);
  EXPECT_EQ(source.counts()["steps_not_converged"], bad);
  EXPECT_EQ(source.counts()["inverted_tets"]["now"], 0);
  EXPECT_EQ(source.counts()["inverted_tets"]["most"], 0);
  source.reset();
  EXPECT_EQ(source.counts()["steps_not_converged"], 0);
}

/// Nothing is fast in the small scene. A ball that moves by 5 cm in a step is, at a plate of 1 cm.
TEST(LiveSource, CountsStepsInWhichSomethingMayHavePassedUnseen) {
  const auto quiet = test::small_source();
  test::run(*quiet, 10);
  EXPECT_EQ(quiet->counts()["too_far"]["steps"], 0);
  const Scene scene = read_scene_text(
      R"({"name": "shot", "time_step": 0.005, "gravity": [0, 0, 0], "contact": {"continuous": "off"}, "bodies": [
    {"name": "plate", "obstacle": true, "box": {"cells": [4, 4, 1], "size": [0.04, 0.04, 0.01]}},
    {"name": "ball", "ball": {"radius": 0.01, "resolution": 2}, "translate": [0, 0, 0.08],
     "velocity": [0, 0, -10], "material": {"young_modulus": 1e5}}]})",
      "shot");
  LiveSource source(scene, test::small_model(scene), 1);
  test::run(source, 3);
  EXPECT_GE(source.counts()["too_far"]["steps"], 1);
  EXPECT_NEAR(source.counts()["too_far"]["thinnest"].get<double>(), 0.006, 0.004);
  source.reset();
  EXPECT_EQ(source.counts()["too_far"]["steps"], 0);
}

TEST(LiveSource, ChangesSettingsWhileItRuns) {
  const auto source = test::small_source();
  test::run(*source, 5);
  source->apply(1, Change{{{"gravity", {0, 0, 0}}, {"contact", {{"structure", "hash"}}}}});
  EXPECT_EQ(source->settings()["gravity"], nlohmann::json({0.0, 0.0, 0.0}));
  EXPECT_EQ(source->settings()["contact"]["structure"], "hash");
  EXPECT_EQ(source->settings()["contact"]["friction"], 0.3);
  EXPECT_THROW(source->apply(1, Change{{{"contact", {{"friction", -1}}}}}), Error);
  EXPECT_EQ(source->settings()["contact"]["friction"], 0.3);
  source->reset();
  EXPECT_EQ(source->settings()["contact"]["structure"], "hash") << "a reset keeps what was set";
}

}  // namespace
}  // namespace palpate::view
