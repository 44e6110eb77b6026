#pragma once

#include <string>
#include <vector>

#include <palpate/mesh.hpp>

#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate::test {

/// Bodies and the positions at which to look for contacts.
struct ContactScene {
  Bodies bodies;
  std::vector<Vec3> positions;
  std::vector<std::uint8_t> immovable;
};

/// A name of a scene as the name of a test.
inline std::string identifier(std::string name) {
  for (char& c : name) c = c == ' ' || c == '-' ? '_' : c;
  return name;
}

inline constexpr int contact_scene_kinds = 13;
inline const char* contact_scene_name(int kind) {
  constexpr const char* names[contact_scene_kinds] = {"random soups",
                                                      "soups on an integer grid",
                                                      "identical bodies on top of each other",
                                                      "aligned boxes",
                                                      "slivers",
                                                      "inverted and flat tets",
                                                      "coordinates around 1e-9",
                                                      "coordinates around 1e6",
                                                      "ball in a box",
                                                      "far apart and of very different size",
                                                      "stretched",
                                                      "clustered",
                                                      "wide range of sizes"};
  return names[kind];
}

/// Tets of size `size`, each in one of four places that are far from each other, the same for all seeds.
inline TetMesh soup_in_clusters(Random& random, int tets, double size) {
  int corner = 0;
  Vec3 centre;
  return soup(tets, [&] {
    if (corner++ % 4 == 0) centre = {10.0 * random.integer(0, 1), -7.0 * random.integer(0, 1), 3.0};
    return centre + random.point(-size, size);
  });
}

/// Tets around the origin whose sizes are from 1e-3 to 1e3.
inline TetMesh soup_of_many_sizes(Random& random, int tets) {
  int corner = 0;
  double size = 1.0;
  return soup(tets, [&] {
    if (corner++ % 4 == 0) size = std::pow(10.0, random.uniform(-3, 3));
    return size * random.point(-1, 1);
  });
}

/// A small scene of one of the kinds; everything about it follows from the seed.
inline ContactScene make_contact_scene(int kind, std::uint64_t seed) {
  Random random(seed);
  ContactScene scene;
  const auto add = [&](TetMesh mesh) {
    std::string name("b");
    name += std::to_string(scene.bodies.body_count());
    scene.bodies.add(std::move(name), std::move(mesh));
  };
  const auto shifted = [](TetMesh mesh, const Vec3& by) {
    for (Vec3& p : mesh.points) p += by;
    return mesh;
  };
  const int bodies = random.integer(2, 4);
  for (int b = 0; b < bodies; ++b) {
    switch (kind) {
      case 0:
        add(soup(random.integer(1, 12), [&] { return random.point(-1, 1); }));
        break;
      case 1:
        add(soup(random.integer(1, 12), [&] { return random.grid_point(-1, 1, 0.1); }));
        break;
      case 2:
        add(box_mesh({2, 1, 1}, {0, 0, 0}, {2, 1, 1}));
        break;
      case 3: {
        const double step = 0.1;  // not a binary fraction: neighbours agree only as far as rounding does
        add(shifted(box_mesh({2, 2, 1}, {0, 0, 0}, {2 * step, 2 * step, step}),
                    random.grid_point(-2, 2, step)));
        break;
      }
      case 4: {
        const double thin = std::pow(10.0, random.integer(-17, -3));
        add(soup(random.integer(1, 8), [&] {
          Vec3 p = random.grid_point(-2, 2, 0.5);
          p.z += thin * random.integer(-1, 1);
          return p;
        }));
        break;
      }
      case 5:
        add(box_mesh({2, 2, 2}, {0, 0, 0}, {1, 1, 1}));
        break;
      case 6:
        add(soup(random.integer(1, 10), [&] { return 1e-9 * random.point(-1, 1); }));
        break;
      case 7:
        add(soup(random.integer(1, 10), [&] {
          return Vec3{1e6, -1e6, 1e6} + random.grid_point(-4, 4, 1e-9);
        }));
        break;
      case 8:
        if (b == 0)
          add(box_mesh({3, 3, 3}, {-1, -1, -1}, {1, 1, 1}));
        else
          add(ball_mesh(2, random.point(-1, 1), random.uniform(0.1, 1.2)));
        break;
      case 10:
        add(soup(random.integer(1, 12), [&] {
          const Vec3 p = random.point(-1, 1);
          return Vec3{1e3 * p.x, p.y, 1e-2 * p.z};
        }));
        break;
      case 11:
        add(soup_in_clusters(random, random.integer(2, 12), 0.1));
        break;
      case 12:
        add(soup_of_many_sizes(random, random.integer(2, 12)));
        break;
      default:
        add(shifted(box_mesh({2, 2, 2}, {0, 0, 0}, {1, 1, 1}), random.point(-1, 1)));
        add(shifted(box_mesh({1, 1, 1}, {0, 0, 0}, {0.01, 0.01, 0.01}), random.point(-1, 1)));
        if (random.chance(0.3))
          add(shifted(box_mesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1}), random.point(500, 1000)));
        break;
    }
  }
  scene.positions.assign(scene.bodies.points_rest().begin(), scene.bodies.points_rest().end());
  if (kind == 5) {  // move points so far that tets turn inside out, and put some into one place
    for (Vec3& p : scene.positions) {
      if (random.chance(0.4)) p = random.grid_point(-1, 2, 0.5);
    }
  }
  scene.immovable.assign(scene.bodies.bodies().size(), 0);
  for (std::uint8_t& flag : scene.immovable) flag = random.chance(0.2) ? 1 : 0;
  return scene;
}

inline constexpr int large_scene_kinds = 5;
inline const char* large_scene_name(int kind) {
  constexpr const char* names[large_scene_kinds] = {"random", "degenerate", "stretched", "clustered",
                                                    "wide range"};
  return names[kind];
}

/// A scene of several thousand points: enough for several chunks of each loop, so that threads matter. Tets
/// of a size, each around a centre of its own, far enough apart that few of them meet.
inline ContactScene make_large_scene(int kind, std::uint64_t seed) {
  Random random(seed);
  ContactScene scene;
  int corner = 0;
  Vec3 centre;
  double size = 0.2;
  const auto make_point = [&]() -> Vec3 {
    const bool first = corner++ % 4 == 0;
    switch (kind) {
      case 1:
        if (first) centre = random.grid_point(-20, 20, 0.1);
        return centre + random.grid_point(-2, 2, 0.1);
      case 3:
        if (first)
          centre =
              Vec3{100.0 * random.integer(0, 1), -70.0 * random.integer(0, 1), 3.0} + random.point(-1, 1);
        return centre + random.point(-size, size);
      case 4:
        if (first) {
          size = std::pow(10.0, random.uniform(-3, 3));
          centre = size * random.point(-12, 12);
        }
        return centre + size * random.point(-1, 1);
      default: {
        if (first) centre = random.point(-2, 2);
        const Vec3 p = centre + random.point(-size, size);
        return kind == 2 ? Vec3{1e3 * p.x, p.y, 1e-2 * p.z} : p;
      }
    }
  };
  for (int b = 0; b < 3; ++b)
    scene.bodies.add(std::string("b").append(std::to_string(b)), soup(500, make_point));
  scene.positions.assign(scene.bodies.points_rest().begin(), scene.bodies.points_rest().end());
  scene.immovable.assign(scene.bodies.bodies().size(), 0);
  return scene;
}

}  // namespace palpate::test
