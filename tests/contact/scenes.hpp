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

inline constexpr int contact_scene_kinds = 10;
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
                                                      "far apart and of very different size"};
  return names[kind];
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

}  // namespace palpate::test
