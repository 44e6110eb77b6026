// Two small bodies with real coordinates have a contact exactly where they meet, touching included: random
// pairs, and pairs that are within units in the last place of touching. Oracle: all pairs of surface
// triangles in exact arithmetic (tests/support/surfaces_meet.hpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <numbers>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/surfaces_meet.hpp"

namespace palpate {
namespace {

using test::Random;

/// How the second body of a pair is placed.
enum Placement { at_random, touching, glued, nested, copied, placements };

/// A tet with corners at random, or a thin one.
TetMesh one_tet(Random& random, bool thin) {
  TetMesh mesh{.points = {}, .tets = {{0, 1, 2, 3}}};
  for (int i = 0; i < 4; ++i) mesh.points.push_back(random.point(-0.5, 0.5));
  auto& p = mesh.points;
  const Vec3 normal = normalized(cross(p[1] - p[0], p[2] - p[0]));
  const double height = thin ? std::pow(10.0, random.uniform(-5, -2)) : random.uniform(0.1, 0.6);
  p[3] = across(p[3] - p[0], normal) + p[0] + height * normal;
  return mesh;
}

/// Bodies of one to eight tets; those of two and more may have dents.
TetMesh small_mesh(Random& random, int shape) {
  if (shape < 2) return one_tet(random, shape == 1);
  if (shape == 2) {  // two tets on different sides of a face
    TetMesh mesh = one_tet(random, false);
    const auto& p = mesh.points;
    mesh.points.push_back(p[0] - random.uniform(0.3, 1.0) * (p[3] - p[0]) +
                          random.uniform(-0.5, 1) * (p[1] - p[0]) + random.uniform(-0.5, 1) * (p[2] - p[0]));
    mesh.tets.push_back({0, 2, 1, 4});
    return mesh;
  }
  if (shape == 3) return test::box_mesh({1, 1, 1}, -1.0 * random.point(0.1, 0.5), random.point(0.1, 0.5));
  TetMesh mesh{.points = {{0, 0, -0.4}, {0, 0, 0.3}}, .tets = {}};  // a fan about an edge
  const int around = random.integer(3, 8);
  for (int i = 0; i < around; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / around;
    const double radius = random.uniform(0.15, 0.5);
    mesh.points.push_back({radius * std::cos(angle), radius * std::sin(angle), random.uniform(-0.1, 0.1)});
    mesh.tets.push_back({0, 1, 2 + i, 2 + (i + 1) % around});
  }
  return mesh;
}

/// Moves a number by up to two units in its last place.
void nudge(double& x, Random& random) {
  for (int i = random.integer(-2, 2); i != 0; i += i < 0 ? 1 : -1) x = std::nextafter(x, i * HUGE_VAL);
}
/// Moves all points of a body by units in the last place, or one point or all points together by up to a
/// hundredth of the size of the body.
void nudge(std::span<Vec3> points, Random& random) {
  const int kind = random.integer(0, 2);
  const double most = length(points[1] - points[0]) * std::pow(10.0, random.uniform(-17, -2));
  const Vec3 by = most * random.point(-1, 1);
  const auto one = static_cast<std::size_t>(random.integer(0, static_cast<int>(points.size()) - 1));
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vec3& p = points[i];
    if (kind == 0) {
      for (double* x : {&p.x, &p.y, &p.z}) nudge(*x, random);
    } else if (kind == 1 || i == one) {
      p += by;
    }
  }
}

/// Pairs of bodies, in the cells of a lattice, each pair far from the others.
struct Pairs {
  Pairs(std::uint64_t seed, int pairs, double body_size, double offset)
      : random(seed), size(body_size), origin(offset * random.point(0.5, 1)) {
    for (int i = 0; i < 2 * pairs; ++i) {
      const int placement = i / 2 % placements;
      const bool second = i % 2 == 1;
      int shape = random.integer(0, 4);
      if (second && placement == glued) shape = random.integer(0, 1);
      TetMesh mesh = small_mesh(random, shape);
      if (second && placement == copied) mesh = of_first;
      of_first = mesh;
      for (Vec3& p : mesh.points) p = size * p;
      bodies.add("b", std::move(mesh));
    }
    x.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    back.resize(static_cast<std::size_t>(pairs));
  }

  [[nodiscard]] Index count() const { return bodies.body_count() / 2; }
  [[nodiscard]] const Body& body(Index b) const { return at(bodies.bodies(), b); }
  std::span<Vec3> points(Index b) {
    const Range range = body(b).points;
    return std::span(x).subspan(static_cast<std::size_t>(range.begin),
                                static_cast<std::size_t>(range.end - range.begin));
  }

  /// Puts a body into the cell of its pair, rotated at random.
  void put(Index b, double factor) {
    const Vec3 axis = random.point(-1, 1);
    const double angle = random.uniform(-3, 3);
    const int i = static_cast<int>(b / 2);
    const Vec3 cell{8.0 * (i % 10), 8.0 * (i / 10 % 10), 8.0 * (i / 100)};
    const auto first = static_cast<std::size_t>(body(b).points.begin);
    for (std::size_t p = 0; Vec3 & point : points(b))
      point = origin + factor * test::rotated(bodies.points_rest()[first + p++], axis, angle) + size * cell;
  }

  /// A place on the surface: a corner, or a point inside an edge or a face, and a direction. A plane there
  /// across this direction has the body on one side, if the body is convex.
  struct Place {
    Vec3 point;
    Vec3 normal;
    Triangle triangle;
  };
  Place place_on(Index b, int corners) {
    const Range range = body(b).triangles;
    Place place{{}, {}, at(bodies.triangles(), random.integer(range.begin, range.end - 1))};
    const std::span some(place.triangle.data(), static_cast<std::size_t>(corners));
    double left = 1.0;
    for (const Index corner : some) {
      const double weight = corner == some.back() ? left : left * random.uniform(0.1, 0.9);
      left -= weight;
      place.point += weight * at(x, corner);
    }
    for (Index t = range.begin; t < range.end; ++t) {
      const Triangle& c = at(bodies.triangles(), t);
      if (!std::ranges::all_of(some, [&](Index p) { return std::ranges::find(c, p) != c.end(); })) continue;
      const auto side = [&](std::size_t i) { return (1.0 / size) * (at(x, c[i]) - at(x, c[0])); };
      const Vec3 normal = cross(side(1), side(2));  // of sides near 1, whose squares are finite
      place.normal += random.uniform(0.1, 1.0) * normalized(normal);
    }
    place.normal = normalized(place.normal);
    return place;
  }

  /// Puts a corner, edge or face of b on one of a, from outside, or a little above or below it.
  void touch(Index a, Index b) {
    const Place on_a = place_on(a, random.integer(1, 3));
    const Place on_b = place_on(b, random.integer(1, 3));
    const Vec3 axis = cross(on_b.normal, -on_a.normal);
    const double angle = std::atan2(length(axis), -dot(on_b.normal, on_a.normal));
    const double spin = random.uniform(-3, 3);
    const double gap = random.integer(-1, 1) * size * std::pow(10.0, random.uniform(-17, -2));
    const Vec3 to = on_a.point + gap * on_a.normal;
    at(back, a / 2) = gap * -on_a.normal;
    for (Vec3& p : points(b))
      p = test::rotated(test::rotated(p - on_b.point, axis, angle), on_a.normal, spin) + to;
  }

  /// Puts a face of the tet b on one of a, so that all corners are equal.
  void glue(Index a, Index b) {
    const Place face = place_on(a, 3);
    const auto p = points(b);
    for (std::size_t i = 0; i < 3; ++i) p[i] = at(x, face.triangle[i]);
    p[3] = face.point + random.uniform(1e-3, 1) * size * face.normal;
  }

  /// Puts the small body b onto a point of a tet of a.
  void nest(Index a, Index b) {
    const Range tets = body(a).tets;
    const Tet& tet = at(bodies.tets(), random.integer(tets.begin, tets.end - 1));
    Vec3 inside{};
    for (const Index corner : tet) inside += 0.25 * at(x, corner);
    const Vec3 from = points(b)[0];
    for (Vec3& p : points(b)) p += inside - from;
  }

  /// Gives b the positions of a, or moves it from there by the difference of two points of a.
  void copy(Index a, Index b) {
    const auto from = points(a);
    const auto any = [&] {
      return from[static_cast<std::size_t>(random.integer(0, static_cast<int>(from.size()) - 1))];
    };
    const Vec3 by = random.chance(0.5) ? any() - any() : Vec3{};
    for (std::size_t p = 0; p < from.size(); ++p) points(b)[p] = from[p] + by;
  }

  void place_all() {
    for (Index pair = 0; pair < count(); ++pair) {
      const Index a = 2 * pair;
      const Index b = a + 1;
      const int placement = static_cast<int>(pair) % placements;
      put(a, 1.0);
      put(b, std::pow(10.0, placement == nested ? random.uniform(-3, -0.5) : random.uniform(-1.5, 0)));
      if (placement == at_random) {
        const Vec3 by = random.uniform(0, size) * random.point(-1, 1);
        for (Vec3& p : points(b)) p += by;
      }
      if (placement == touching) touch(a, b);
      if (placement == glued) glue(a, b);
      if (placement == nested) nest(a, b);
      if (placement == copied) copy(a, b);
      if (random.chance(0.7)) nudge(points(b), random);
    }
  }
  /// Moves bodies by a little, and some of those that were put above or below another towards its surface or
  /// just through it.
  void move_all() {
    for (Index b = 0; b < bodies.body_count(); ++b) {
      if (random.chance(0.5)) nudge(points(b), random);
      Vec3& rest = at(back, b / 2);
      if (b % 2 == 0 || random.chance(0.3)) continue;
      const double part = random.chance(0.5) ? 1.02 : random.uniform(0.3, 1);
      for (Vec3& p : points(b)) p += part * rest;
      rest -= part * rest;
    }
  }

  Random random;
  double size;
  Vec3 origin;
  TetMesh of_first;
  Bodies bodies;
  std::vector<Vec3> x;
  std::vector<Vec3> back;  ///< (n_pairs) from above or below to the surface
};

/// The pairs of bodies with contacts of points (1), of edges (2), or both (3).
std::vector<int> pairs_found(const Pairs& pairs, const Detector& detector) {
  std::vector<int> found(static_cast<std::size_t>(pairs.count()), 0);
  const auto add = [&](Index a, Index b, int kind) {
    EXPECT_EQ(a / 2, b / 2) << "other pairs are far";
    if (a != b) at(found, a / 2) |= kind;
  };
  const Contacts& points = detector.contacts();
  for (std::size_t c = 0; c < points.size(); ++c)
    add(at(pairs.bodies.body_of_point(), points.point[c]), points.body[c], 1);
  const EdgeContacts& edges = detector.edge_contacts();
  for (std::size_t c = 0; c < edges.size(); ++c)
    add(pairs.bodies.body_of(at(pairs.bodies.edges(), edges.edge[c])), edges.body[c], 2);
  return found;
}

/// The points of a pair in hexadecimal, to be copied into a test.
std::string text_of(Pairs& pairs, Index pair) {
  std::ostringstream text;
  text << std::hexfloat;
  for (const Index b : {2 * pair, 2 * pair + 1}) {
    for (const Vec3& p : pairs.points(b)) text << "{" << p.x << ", " << p.y << ", " << p.z << "},\n";
    const Body& body = pairs.body(b);
    for (Index t = body.tets.begin; t < body.tets.end; ++t) {
      text << "tet";
      for (const Index corner : at(pairs.bodies.tets(), t)) text << " " << corner - body.points.begin;
      text << "\n";
    }
  }
  return text.str();
}

/// What is counted.
enum Outcome { met, by_edges_only, inside, apart, close_apart, outcomes };
using Counts = std::array<std::array<int, outcomes>, placements>;

void check_frame(Pairs& pairs, Detector& detector, Counts& counts) {
  detector.detect(pairs.x);
  const std::vector<int> found = pairs_found(pairs, detector);
  for (Index pair = 0; pair < pairs.count(); ++pair) {
    const test::Meeting meeting = test::rational_meeting(pairs.bodies, pairs.x, 2 * pair, 2 * pair + 1);
    const bool do_meet = meeting.surfaces || meeting.nested;
    ASSERT_EQ(at(found, pair) != 0, do_meet) << "pair " << pair << "\n" << text_of(pairs, pair);
    std::array<int, outcomes>& count = at(counts, pair % placements);
    ++count[do_meet ? met : apart];
    if (meeting.nested) ++count[inside];
    if (at(found, pair) == 2) ++count[by_edges_only];
    if (!do_meet && meeting.close) ++count[close_apart];
  }
}

/// That no kind of pair is rare.
void expect_many_of_each(const Counts& counts, int pairs) {
  // Percent of the pairs of a placement: met, by edges only, one inside the other, apart, close to touching
  constexpr Counts least{
      {{20, 3, 5, 60, 0}, {40, 10, 0, 30, 10}, {70, 12, 0, 12, 3}, {90, 0, 60, 0, 0}, {70, 10, 0, 10, 4}}};
  for (std::size_t i = 0; i < placements; ++i) {
    for (std::size_t k = 0; k < outcomes; ++k)
      EXPECT_GE(100 * counts[i][k], least[i][k] * (pairs / placements)) << i << " " << k;
  }
}

/// Models of 10 to 1000 pairs, each in eight frames: placed, moved a little three times, and again.
void expect_contacts_exactly_where_bodies_meet(int wanted) {
  // Sizes, and distances from the origin in sizes: digits are lost there.
  constexpr std::array<std::array<double, 2>, 7> scales{
      {{1, 0}, {1, 1e3}, {1e-3, 1e5}, {1e-6, 0}, {1e6, 1}, {1e-90, 10}, {1e90, 0}}};
  constexpr std::array<int, 3> sizes{1000, 10, 100};
  Counts counts{};
  int checked = 0;
  for (int round = 0; checked < wanted; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    const auto [size, sizes_away] = at(scales, round % std::ssize(scales));
    Pairs pairs(static_cast<std::uint64_t>(round), at(sizes, round % std::ssize(sizes)), size,
                size * sizes_away);
    DetectionSettings settings;
    settings.coherence = round % 2 == 0;
    if (round % 4 < 2) settings.self_collision.assign(pairs.bodies.bodies().size(), 1);
    Detector detector(pairs.bodies, settings, {}, 1);
    for (int frame = 0; frame < 8; ++frame) {
      frame % 4 == 0 ? pairs.place_all() : pairs.move_all();
      check_frame(pairs, detector, counts);
      if (::testing::Test::HasFailure()) return;
      checked += pairs.count();
    }
  }
  expect_many_of_each(counts, checked);
}

TEST(EdgeContactsOfPairs, AreThereExactlyWhereSmallBodiesMeet) {
  expect_contacts_exactly_where_bodies_meet(60'000);
}

TEST(EdgeContactsOfPairs, DISABLED_AreThereExactlyWhereTwoMillionPairsMeet) {
  expect_contacts_exactly_where_bodies_meet(2'000'000);
}

/// Distances are stored in float, which has no numbers above 3e38.
TEST(EdgeContactsOfPairs, OfVeryLargeBodiesAreFoundAfterAMotion) {
  for (const double s : {1.0, 1e38, 1e41, 1e60, 1e90}) {
    Bodies bodies;
    bodies.add("ridge", {.points = {{-s, 0, 0}, {s, 0, 0}, {0, -s, -s}, {0, s, -s}}, .tets = {{0, 1, 2, 3}}});
    bodies.add("across", {.points = {{0, -s, -0.1 * s}, {0, s, -0.1 * s}, {-s, 0, s}, {s, 0, s}},
                          .tets = {{0, 1, 2, 3}}});
    std::vector<Vec3> beside(bodies.points_rest().begin(), bodies.points_rest().end());
    for (std::size_t p = 4; p < 8; ++p) beside[p] += {1.3 * s, 1.3 * s, 0};
    Detector detector(bodies, {}, {}, 1);
    detector.detect(beside);
    EXPECT_EQ(detector.edge_contacts().size(), 0U) << s;
    detector.detect(bodies.points_rest());
    EXPECT_EQ(detector.edge_contacts().size(), 2U) << s << ": each ridge goes through the other body";
    EXPECT_EQ(detector.contacts().size(), 0U) << s;
  }
}

}  // namespace
}  // namespace palpate
