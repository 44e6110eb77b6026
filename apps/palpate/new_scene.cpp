#include "new_scene.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <system_error>

#include "exit_codes.hpp"
#include "geometry/vector.hpp"
#include "numbers.hpp"
#include "scene_input.hpp"
#include "size_warnings.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

double longest_side(const TetMesh& mesh) {
  Vec3 lower = at(mesh.points, mesh.tets.front()[0]);
  Vec3 upper = lower;
  for (const Tet& tet : mesh.tets) {
    for (const Index corner : tet) {
      const Vec3& p = at(mesh.points, corner);
      lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
      upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
  }
  const Vec3 sides = upper - lower;
  return std::max({sides.x, sides.y, sides.z});
}

double longest(const Vec3& size) {
  return std::max({size.x, size.y, size.z});
}

/// The path of the mesh as seen from `folder`: relative where possible, so that both can be moved together.
std::string mesh_from(const fs::path& folder, const fs::path& mesh) {
  std::error_code failed;
  const fs::path relative = fs::relative(mesh, folder.empty() ? "." : folder, failed);
  return failed || relative.empty() ? fs::absolute(mesh).string() : relative.string();
}

}  // namespace

NewScene new_scene_of(const NewSceneRequest& request) {
  if (!is_mesh(request.mesh)) {
    throw BadInput(
        request.mesh.string(), "", "the extension '" + request.mesh.extension().string() + "'",
        "a mesh of tets (.vtu .vtk .msh .node .ele .mesh); 'palpate mesh' makes them of surfaces and "
        "label maps");
  }
  const MeshInput input = read_mesh_input(request.mesh);
  NewScene made{.request = request, .longest_side = longest_side(input.mesh), .unit = {}, .first = {}};
  made.unit = request.unit.value_or(guess_unit(made.longest_side));
  if (request.longest) made.unit = {"", *request.longest / made.longest_side};
  const std::string file = mesh_from(request.folder, request.mesh);
  made.first = as_input([&] {
    return make_first_scene(request.mesh.stem().string(), file, input.mesh,
                            {.meters = made.unit.meters, .drop = request.drop});
  });
  made.first.scene.folder = request.folder;
  made.first.scene.source = request.mesh.string();
  return made;
}

std::string description_of(const NewScene& made) {
  const Vec3& size = made.first.size;
  const std::string unit =
      made.unit.name.empty() ? "scaled by " + short_text(made.unit.meters) : "in " + made.unit.name;
  const char* const held = "its lowest tenth is held, and an instrument presses it";
  const char* const dropped = "it falls onto a floor, and then a plate presses it";
  return fmt::format("{} {}: {}, {}; {}", made.request.mesh.string(), unit, length_text(longest(size)),
                     mass_text(made.first.mass), made.request.drop ? dropped : held);
}

std::string guess_of(const NewScene& made) {
  if (!made.unit.name.empty()) return fmt::format("unit guessed: {} (choose with --unit)", made.unit.name);
  return fmt::format("no unit fits a length of {}: scaled to {} (choose with --unit or --size)",
                     short_text(made.longest_side), length_text(longest(made.first.size)));
}

std::string stiffness_of(const NewScene& made) {
  const double modulus = made.first.scene.bodies.front().material->young_modulus;
  const std::string why = modulus > softest_first_body
                              ? "the softest that keeps the shape of this body under its weight"
                              : "as of a soft organ";
  constexpr double mega = 1e6;
  const std::string value = modulus < mega ? fmt::format("{:.3g} kPa", 1e-3 * modulus)
                                           : fmt::format("{} MPa", short_text(1e-6 * modulus));
  return fmt::format("young_modulus is {}, {}; set it to that of the tissue", value, why);
}

std::string command_of(const NewScene& made) {
  std::string text = "palpate new " + path_word(made.request.mesh.string());
  if (made.request.unit) text += " --unit " + made.request.unit->name;
  if (made.request.longest) text += " --size " + exact_text(*made.request.longest);
  if (made.request.drop) text += " --drop";
  return text;
}

}  // namespace palpate::app
