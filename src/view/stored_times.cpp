#include "view/stored_times.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::view {
namespace {

/// "time" and the phases, with the names of metrics.csv without units.
constexpr std::array<std::string_view, 1 + phase_names.size()> columns{
    "time",       "wall_grid",   "wall_contacts", "wall_border_edges", "wall_crossings",
    "wall_depth", "wall_forces", "wall_solver",   "wall_step"};
using Places = std::array<std::size_t, columns.size()>;

/// The fields of a line; in these columns nothing is quoted.
std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

std::optional<Places> places_in(std::string_view header) {
  const std::vector<std::string_view> fields = fields_of(header);
  Places places{};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto field = std::ranges::find_if(
        fields, [&](std::string_view f) { return f.substr(0, f.find(" [")) == columns[c]; });
    if (field == fields.end()) return std::nullopt;
    places[c] = static_cast<std::size_t>(field - fields.begin());
  }
  return places;
}

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failed == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<StoredStep> read_row(std::string_view line, const Places& places) {
  const std::vector<std::string_view> fields = fields_of(line);
  std::array<double, columns.size()> values{};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto value = places[c] < fields.size() ? number(fields[places[c]]) : std::nullopt;
    if (!value) return std::nullopt;
    values[c] = *value;
  }
  StoredStep step{values[0], {}};
  std::copy(values.begin() + 1, values.end(), step.seconds.begin());
  return step;
}

}  // namespace

std::vector<StoredStep> read_stored_times(const std::filesystem::path& metrics) {
  std::ifstream stream(metrics);
  std::string line;
  std::vector<StoredStep> steps;
  if (!std::getline(stream, line)) return steps;
  const std::optional<Places> places = places_in(line);
  while (places && std::getline(stream, line)) {
    if (const std::optional<StoredStep> step = read_row(line, *places)) steps.push_back(*step);
  }
  return steps;
}

PhaseSeconds mean_seconds(const std::vector<StoredStep>& steps, double begin, double end) {
  // Times in the two files are equal up to rounding.
  const double slack = 1e-9 * std::max(end - begin, 0.0);
  PhaseSeconds sum{};
  std::size_t count = 0;
  for (const StoredStep& step : steps) {
    if (step.time <= begin + slack || step.time > end + slack) continue;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += step.seconds[i];
    ++count;
  }
  for (double& seconds : sum) seconds /= static_cast<double>(std::max<std::size_t>(count, 1));
  return sum;
}

}  // namespace palpate::view
