#include "scene_folder.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <palpate/error.hpp>

#include "io/atomic_file.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* scene_name = "scene.json";

void check_place(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored))
    throw Error(path.string(), "", "a folder", "a regular file, or none yet");
}

}  // namespace

SceneFolder::SceneFolder(fs::path folder)
    : folder_(std::move(folder)), unfinished_(folder_ / fmt::format(".{}.{}.part", scene_name, ::getpid())) {
  check_place(folder_ / scene_name);
  std::error_code ignored;
  is_new_ = !fs::exists(folder_, ignored);
  io::create_folder(unfinished_);
}

SceneFolder::~SceneFolder() {
  std::error_code ignored;
  fs::remove_all(unfinished_, ignored);
  if (is_new_) fs::remove(folder_, ignored);  // if it is empty
}

fs::path SceneFolder::place(const std::string& name) {
  check_place(folder_ / name);
  names_.push_back(name);
  return unfinished_ / name;
}

std::vector<std::string> SceneFolder::commit(std::string_view scene) {
  io::write_atomically(unfinished_ / scene_name, scene);
  const auto check = [](const fs::path& path, const std::error_code& failed) {
    if (failed) {
      throw Error(path.string(), "moving it into place", "'" + failed.message() + "'",
                  "a folder that can be written to");
    }
  };
  std::error_code failed;
  fs::remove(folder_ / scene_name, failed);
  check(folder_ / scene_name, failed);
  names_.emplace_back(scene_name);
  for (const std::string& name : names_) {
    fs::rename(unfinished_ / name, folder_ / name, failed);
    check(folder_ / name, failed);
  }
  std::vector<std::string> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".vtu" && std::ranges::count(names_, name) == 0) others.push_back(name);
  }
  std::ranges::sort(others);
  return others;
}

void add_warning_of_others(const std::vector<std::string>& names, std::vector<std::string>& warnings) {
  if (names.empty()) return;
  warnings.push_back(fmt::format("{}: in the folder of the scene, but not of it", fmt::join(names, ", ")));
}

}  // namespace palpate::app
