#include "mesh_scene.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

namespace palpate::app {

std::string mesh_file_name(const std::string& organ, std::set<std::string>& used) {
  std::string stem = organ;
  std::ranges::replace_if(
      stem, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-' && c != '_'; }, '-');
  std::string name = stem + ".vtu";
  for (int other = 2; !used.insert(name).second; ++other) name = fmt::format("{}-{}.vtu", stem, other);
  return name;
}

SceneBody first_body(const std::string& name, const std::string& file, bool rigid,
                     const std::optional<std::array<double, 3>>& color) {
  SceneBody body;
  body.name = name;
  body.source = MeshFile{file};
  body.color = color;
  body.obstacle = rigid;
  if (!rigid) body.material = first_tissue;
  return body;
}

Scene first_scene(const std::string& name) {
  Scene scene;
  scene.name = name;
  scene.units = {"mm", "g", "s"};
  scene.settings.gravity = {};
  scene.settings.rest = {.speed = 0.1, .time = 0.1};
  scene.duration = 2.0;
  scene.relax = RelaxSettings{};
  return scene;
}

}  // namespace palpate::app
