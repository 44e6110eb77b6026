#include "label_table.hpp"

#include <fmt/format.h>
#include <fstream>
#include <optional>
#include <regex>
#include <set>
#include <string>

#include <palpate/error.hpp>

#include "io/file_bytes.hpp"

namespace palpate::app {
namespace {

constexpr double most = 255.0;

LabelName label_name(const std::string& label, std::string name, const std::array<std::string, 3>& color) {
  LabelName entry{std::stoi(label), std::move(name), std::array<double, 3>{}};
  for (std::size_t c = 0; c < 3; ++c) (*entry.color)[c] = std::min(std::stod(color[c]) / most, 1.0);
  return entry;
}

std::optional<LabelName> parse(const std::string& line) {
  static const std::regex snap(
      R"re(\s*(\d{1,9})\s+(\d{1,3})\s+(\d{1,3})\s+(\d{1,3})\s+[\d.]+\s+\d\s+\d\s+"(.*)"\s*)re");
  static const std::regex slicer(
      R"re(\s*(\d{1,9})\s+(\S+)\s+(\d{1,3})\s+(\d{1,3})\s+(\d{1,3})(\s+\d{1,3})?\s*)re");
  std::smatch found;
  if (std::regex_match(line, found, snap))
    return label_name(found[1], found[5], {found[2], found[3], found[4]});
  if (std::regex_match(line, found, slicer))
    return label_name(found[1], found[2], {found[3], found[4], found[5]});
  return std::nullopt;
}

}  // namespace

std::vector<LabelName> read_label_table(const std::filesystem::path& path) {
  io::require_regular_file(path, "a table of labels");
  std::ifstream file(path);
  if (!file) throw Error(path.string(), "", "a file that cannot be read", "a table of labels");
  std::vector<LabelName> names;
  std::set<std::int32_t> seen;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line.starts_with('#')) continue;
    const std::string where = fmt::format("line {}", number);
    const auto entry = parse(line);
    constexpr std::size_t shown = 60;
    if (!entry) {
      throw Error(path.string(), where, "'" + line.substr(0, shown) + "'",
                  "LABEL NAME RED GREEN BLUE, or a line of ITK-SNAP");
    }
    if (!seen.insert(entry->label).second) {
      throw Error(path.string(), where, fmt::format("label {} for the second time", entry->label),
                  "each label once");
    }
    names.push_back(*entry);
  }
  if (names.empty()) throw Error(path.string(), "", "no label", "LABEL NAME RED GREEN BLUE in each line");
  return names;
}

}  // namespace palpate::app
