#include "scene/body_mesh.hpp"

#include <string>
#include <utility>
#include <variant>

#include <palpate/error.hpp>

#include "scene/generators.hpp"
#include "scene/json_text.hpp"

namespace palpate {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// Makes a generated mesh. Errors of the generator become errors of the scene, at `path`, the key of the
/// body.
template <class Generate>
TetMesh generated(const Scene& scene, const std::string& path, Generate&& generate) {
  try {
    return generate();
  } catch (const Error& error) {
    throw Error(scene.source, path + "." + error.source() + "." + error.where(), error.found(),
                error.expected());
  }
}

}  // namespace

TetMesh body_mesh(const Scene& scene, std::size_t body, const MeshReader& read_mesh) {
  const std::string path = element_path("bodies", body);
  const auto read_file = [&](const MeshFile& file) {
    try {
      return read_mesh(scene.folder / file.path);
    } catch (const Error& error) {  // so that the message also names the scene
      throw Error(scene.source,
                  path + ".mesh, " + error.source() + (error.where().empty() ? "" : ", " + error.where()),
                  error.found(), error.expected());
    }
  };
  return std::visit(Overloaded{read_file,
                               [&](const BoxGenerator& box) {
                                 return generated(scene, path, [&] { return make_box(box.cells, box.size); });
                               },
                               [&](const BallGenerator& ball) {
                                 return generated(scene, path,
                                                  [&] { return make_ball(ball.radius, ball.resolution); });
                               }},
                    scene.bodies[body].source);
}

}  // namespace palpate
