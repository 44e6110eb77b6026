// Instructions of the hot kernels, counted by valgrind's callgrind: a change that costs some is seen on the
// busiest machine. Callgrind has no AVX-512, so kernels run with AVX2.
#include <algorithm>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <spawn.h>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <palpate/error.hpp>

#include "measure/query_scenes.hpp"
#include "speed/kernels.hpp"
#include "speed/part.hpp"
#include "temporary_folder.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

constexpr int usual_frames = 4;
constexpr double usual_tets = 1e4;

std::string content_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Runs a program to its end, its output in files. Throws Error where it fails.
void run(std::vector<std::string> words, const std::string& out, const std::string& err) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  posix_spawn_file_actions_t files{};
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = 0;
  const int refused = posix_spawnp(&child, words[0].c_str(), &files, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (refused != 0) throw Error("bench speed", "", "no process", "'" + words[0] + "' started");
  int status = 0;
  ::waitpid(child, &status, 0);
  if (status == 0) return;
  std::string said = content_of(err);
  std::ranges::replace(said, '\n', ' ');
  throw Error(
      "bench speed", fmt::format("{} {}", words[words.size() - 2], words.back()),
      fmt::format("it failed: {}", said.substr(said.size() - std::min<std::size_t>(said.size(), 300))),
      "a count");
}

/// The count of all that was collected: the line "totals: N".
double total_of(const std::string& callgrind_file) {
  std::istringstream text(content_of(callgrind_file));
  for (std::string line; std::getline(text, line);) {
    constexpr std::string_view key = "totals: ";
    if (line.starts_with(key)) return std::stod(line.substr(key.size()));
  }
  throw Error(callgrind_file, "", "no totals", "what callgrind writes");
}

/// The program that callgrind runs.
std::string kernels_program() {
  return fs::read_symlink("/proc/self/exe").replace_filename("palpate-bench-kernels").string();
}

bool is_on_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  return false;
}

Json count(const Kernel& kernel, int cells, int frames) {
  const TemporaryFolder folder;
  const std::string units = (folder.path() / "units").string();
  const std::string counts = (folder.path() / "counts").string();
  run({"valgrind", "--tool=callgrind", "--instr-atstart=no", "--collect-atstart=no",
       "--callgrind-out-file=" + counts, kernels_program(), std::to_string(cells), std::string(kernel.name),
       std::to_string(frames)},
      units, (folder.path() / "messages").string());
  const double work = std::stod(content_of(units));
  const double instructions = total_of(counts);
  return {{"name", kernel.name},
          {"unit", kernel.unit},
          {"cells", cells},
          {"frames", frames},
          {"units", work},
          {"instructions", instructions},
          {"per_unit", instructions / work}};
}

}  // namespace

std::string why_not_counted() {
  std::error_code ignored;
  if (!is_on_path("valgrind")) return "there is no valgrind";
  if (!fs::exists(kernels_program(), ignored)) return fmt::format("there is no '{}'", kernels_program());
  return {};
}

Part instructions_part(const SpeedEffort& effort) {
  const int cells = std::max(1, measure::stacking_cells(std::min(effort.most_tets, usual_tets)));
  const int frames = effort.frames_or(usual_frames);
  Part part{"instructions", {}, [](const Json& /*cases*/) { return Json::array(); }};
  for (const Kernel& kernel : kernels)
    part.cases.push_back({std::string(kernel.name), 0.0, [=] { return count(kernel, cells, frames); }});
  return part;
}

}  // namespace palpate::bench
