// The command line, one argument per line. The last flags make runs short and meshes small. Arguments with
// paths outside the folder are dropped.
#include <algorithm>
#include <string>
#include <vector>

#include "apps/palpate/command_line.hpp"
#include "fuzz/fuzzing.hpp"

namespace {

using namespace palpate;

constexpr const char* scene =
    R"({"time_step": 0.01, "duration": 0.05, "output": {"picture": {"size": [32, 32]}}, "bodies": [
  {"box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "obstacle": true}, {"mesh": "tet.mesh", "translate": [0, 0, 0.4], "material": {}}]})";
constexpr const char* mesh =
    "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 "
    "2 3 4 0\nEnd\n";

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\0') continue;  // no argument has one
    if (c == '\n') {
      lines.emplace_back();
    } else {
      lines.back() += c;
    }
  }
  return lines;
}

std::vector<std::string> bounds_of(const std::vector<std::string>& words) {
  if (words[0] == "run") return {"--steps", "2", "--no-picture", "--threads", "1"};
  if (words[0] == "detect") return {"--threads", "1"};
  if (words[0] != "generate" || words.size() < 2) return {};
  if (words[1] == "ball") return {"--resolution", "2"};
  if (words[1] == "box") return {"--cells", "1", "2", "1"};
  if (words[1] == "stacking") return {"--count", "2", "--cells", "2", "2", "1"};
  return {};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  std::filesystem::current_path(folder.path());
  std::vector<std::string> words = lines_of(fuzz::text(data, size));
  const auto leads_out = [](const std::string& word) {
    return word.find("..") != std::string::npos || word.find('/') != std::string::npos || word.size() > 100 ||
           word == "-";  // standard input is the fuzzer's
  };
  if (words.size() > 20 || std::ranges::any_of(words, leads_out)) return 0;
  for (const auto& entry : std::filesystem::directory_iterator("."))
    std::filesystem::remove_all(entry.path());
  folder.write("scene.json", scene);
  folder.write("tet.mesh", mesh);
  for (std::string& bound : bounds_of(words)) words.push_back(std::move(bound));
  std::vector<const char*> arguments{"palpate"};
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const int code = app::run_command_line(static_cast<int>(arguments.size()), arguments.data());
  fuzz::require(code == 0 || code == 1 || code == 2);
  return 0;
}
