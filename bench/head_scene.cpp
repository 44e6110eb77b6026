#include "head_scene.hpp"

#include <string>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/relax.hpp>

#include "geometry/vector.hpp"

namespace palpate::bench {

HeadScene head_scene(const std::filesystem::path& folder) {
  HeadScene head;
  for (const char* part : {"skull", "lower", "upper", "soft"}) {
    TetMesh mesh = io::read_mesh(folder / ("hq_" + std::string(part) + ".mesh")).mesh;
    for (Vec3& p : mesh.points) p = 1e-3 * p;
    head.model.bodies.add(part, mesh);
  }
  head.settings.gravity = {};
  head.model.materials.assign(4, {1e4, 0.4, 1000.0, 0.0, 0.002});
  head.model.obstacles = {1, 1, 1, 0};
  relax(head.model, head.settings, {}, 1);
  Motion motion;
  motion.keyframes = {{.time = 0.0}, {.time = 0.8, .translate = {0.0, -0.002, 0.0}}};
  head.model.motions = {motion};
  head.model.motion_of_point.assign(head.model.bodies.points_rest().size(), -1);
  const Range jaw = head.model.bodies.bodies()[1].points;
  for (Index p = jaw.begin; p < jaw.end; ++p) at(head.model.motion_of_point, p) = 0;
  return head;
}

}  // namespace palpate::bench
