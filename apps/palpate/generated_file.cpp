#include "generated_file.hpp"

#include <fmt/format.h>
#include <stdexcept>
#include <system_error>

#include "exit_codes.hpp"
#include "io/atomic_file.hpp"
#include "io/vtu_writer.hpp"
#include "messages.hpp"
#include "numbers.hpp"
#include "option_values.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

std::string complete(const fs::path& path) {
  return path.string() + " is complete";
}

}  // namespace

fs::path GeneratedFile::path() const {
  std::error_code ignored;
  if (!named && fs::exists(default_name, ignored)) {
    throw BadInput(default_name.string(), "", "an existing file",
                   "a name that does not exist yet; --out FILE replaces an existing file");
  }
  fs::path result = named.value_or(default_name);
  if (result.extension() != default_name.extension()) {
    throw BadInput("--out", "", "'" + result.string() + "'",
                   "a name that ends in " + default_name.extension().string());
  }
  return result;
}

void add_out(CLI::App& app, const std::string& help, GeneratedFile& file) {
  add_value(app, "--out", "FILE", help + "; default: " + file.default_name.string(),
            [&file](const std::string&, const std::string& text) { file.named = text; });
}

void stop_if_interrupted(const InterruptFlag& interrupt, const std::string& state) {
  if (interrupt.requested()) throw std::runtime_error("interrupted; " + state);
}

void write_mesh(const fs::path& path, const TetMesh& mesh) {
  io::write_vtu(path,
                {.points = mesh.points, .tets = mesh.tets, .point_arrays = {}, .tet_arrays = {}, .time = {}});
  print_out(fmt::format("{}: {}, {}\n", path.string(), counted(mesh.points.size(), "point"),
                        counted(mesh.tets.size(), "tet")));
}

fs::path write_generated(const GeneratedFile& file, const std::function<std::string()>& make) {
  fs::path path = file.path();
  const std::string text = as_input([&] { return made(make); });
  const InterruptFlag interrupt;
  io::write_atomically(path, text);
  stop_if_interrupted(interrupt, complete(path));
  return path;
}

void write_generated_mesh(const GeneratedFile& file, const std::function<TetMesh()>& make) {
  const fs::path path = file.path();
  const TetMesh mesh = as_input([&] { return made(make); });
  const InterruptFlag interrupt;
  write_mesh(path, mesh);
  stop_if_interrupted(interrupt, complete(path));
}

}  // namespace palpate::app
