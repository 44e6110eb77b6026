// Counts instructions of kernels with valgrind's callgrind. It has no AVX-512, so kernels run with AVX2.
#include "speed/callgrind.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <map>
#include <spawn.h>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

#include <palpate/error.hpp>

#include "temporary_folder.hpp"

namespace palpate::bench {
namespace {

namespace fs = std::filesystem;

std::string content_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Runs a program to its end, its output in files. Throws Error if it fails.
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

constexpr std::string_view loop_name = "parallel::for_chunks";
constexpr std::string_view chunk_name = "::operator()(unsigned long) const";

}  // namespace

CallgrindCounts parse_callgrind(const std::string& text, const std::string& name) {
  constexpr std::string_view totals = "totals: ";
  constexpr std::string_view callee = "cfn=";
  constexpr std::string_view calls = "calls=";
  CallgrindCounts counts;
  bool has_totals = false;
  std::map<std::string, LoopCount> loops;  // by the name of for_chunks, with the types of its template
  std::string called;
  double times = 0.0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(totals)) {
      counts.instructions = std::stod(line.substr(totals.size()));
      has_totals = true;
    } else if (line.starts_with(callee)) {
      called = line.substr(callee.size());
    } else if (line.starts_with(calls)) {
      times = std::stod(line.substr(calls.size()));
      std::getline(lines, line);  // position and instructions of the calls
      if (called.find(loop_name) == std::string::npos) continue;
      // GCC's clones of a function have a suffix, as ".isra.0".
      const std::size_t chunk = called.find(chunk_name);
      if (chunk == std::string::npos) {
        loops[called].calls += times;
      } else {
        const std::size_t lambda = called.rfind("::{lambda", chunk);
        LoopCount& loop = loops[called.substr(0, lambda)];
        loop.chunks += times;
        loop.instructions += std::stod(line.substr(line.find(' ')));
      }
    }
  }
  if (!has_totals) throw Error(name, "", "no totals", "what callgrind writes");
  for (const auto& [ignored, loop] : loops)
    if (loop.chunks > 0.0) counts.loops.push_back(loop);
  return counts;
}

double longest_chain(const CallgrindCounts& counts, double threads) {
  double chain = counts.instructions;
  for (const LoopCount& loop : counts.loops) {
    const double chunks = std::max(1.0, std::round(loop.chunks / std::max(1.0, loop.calls)));
    chain -= loop.instructions * (1.0 - std::max(1.0, std::ceil(chunks / threads)) / chunks);
  }
  return chain;
}

CallgrindCounts count_with_callgrind(std::string_view kernel, int cells, int frames) {
  const TemporaryFolder folder;
  const std::string units = (folder.path() / "units").string();
  const std::string counts = (folder.path() / "counts").string();
  run({"valgrind", "--tool=callgrind", "--instr-atstart=no", "--collect-atstart=no", "--compress-strings=no",
       "--compress-pos=no", "--callgrind-out-file=" + counts, kernels_program(), std::to_string(cells),
       std::string(kernel), std::to_string(frames)},
      units, (folder.path() / "messages").string());
  CallgrindCounts result = parse_callgrind(content_of(counts), counts);
  result.units = std::stod(content_of(units));
  return result;
}

std::string why_not_counted() {
  std::error_code ignored;
  if (!is_on_path("valgrind")) return "there is no valgrind";
  if (!fs::exists(kernels_program(), ignored)) return fmt::format("there is no '{}'", kernels_program());
  return {};
}

}  // namespace palpate::bench
