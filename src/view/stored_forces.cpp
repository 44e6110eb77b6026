#include "view/stored_forces.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

namespace palpate::view {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t wrench_columns = 6;
constexpr std::size_t row_width = 2 * wrench_columns;
/// Largest number of points in a chart of the whole run.
constexpr std::size_t most_stretches = 1000;

/// The fields of a line of CSV; quotes as RFC 4180 has them. Line breaks in names of bodies are not
/// supported.
std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += line[i++];
      } else {
        quoted = !quoted;
      }
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = failed == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
  return whole ? std::optional(value) : std::nullopt;
}

Json wrench_json(const double* values) {
  return {{"force", {values[0], values[1], values[2]}}, {"torque", {values[3], values[4], values[5]}}};
}

}  // namespace

StoredForces::StoredForces(const std::filesystem::path& file, std::span<const std::string> names) {
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line) || !find_columns(csv_fields(line), names)) return;
  while (std::getline(stream, line)) add_row(csv_fields(line));
}

bool StoredForces::find_columns(const std::vector<std::string>& header, std::span<const std::string> names) {
  const auto column = [&](const std::string& name) -> std::optional<std::size_t> {
    const auto found = std::ranges::find_if(
        header, [&](const std::string& field) { return field.substr(0, field.rfind(" [")) == name; });
    if (found == header.end()) return std::nullopt;
    return static_cast<std::size_t>(found - header.begin());
  };
  const auto six = [&](const std::string& what) -> std::optional<std::size_t> {
    const auto first = column(what + " force_x");
    const auto last = column(what + " torque_z");
    return first && last && *last == *first + wrench_columns - 1 ? first : std::nullopt;
  };
  const auto time = column("time");
  if (!time) return false;
  time_column_ = *time;
  for (const std::string& name : names) {
    const auto contact = six(name + " contact");
    if (!contact) return false;
    columns_.push_back({*contact, six(name + " held")});
  }
  return true;
}

void StoredForces::add_row(const std::vector<std::string>& fields) {
  const auto field = [&](std::size_t place) {
    return place < fields.size() ? number(fields[place]) : std::nullopt;
  };
  const auto time = field(time_column_);
  if (!time || (!times_.empty() && *time <= times_.back())) return;
  std::vector<double> row;
  for (const Columns& body : columns_) {
    for (const std::optional<std::size_t>& first : {std::optional(body.contact), body.held}) {
      for (std::size_t k = 0; k < wrench_columns; ++k) {
        const auto value = first ? field(*first + k) : std::optional(0.0);
        if (!value) return;
        row.push_back(*value);
      }
    }
  }
  times_.push_back(*time);
  values_.insert(values_.end(), row.begin(), row.end());
}

Json StoredForces::at_time(double time) const {
  Json list = Json::array();
  // Times in the two files are equal up to rounding.
  const double slack = 1e-9 * (times_.empty() ? 0.0 : times_.back());
  const auto found = std::ranges::lower_bound(times_, time - slack);
  if (found == times_.end() || *found > time + slack) return list;
  const auto row = static_cast<std::size_t>(found - times_.begin());
  for (std::size_t b = 0; b < columns_.size(); ++b) {
    const double* const values = values_.data() + row_width * (row * columns_.size() + b);
    list.push_back(wrench_json(values));
    if (columns_[b].held) list.back()["held"] = wrench_json(values + wrench_columns);
  }
  return list;
}

Json StoredForces::history() const {
  const std::size_t stretch = (times_.size() + most_stretches - 1) / most_stretches;
  Json times = Json::array();
  std::vector<Json> bodies(columns_.size(), Json::array());
  for (std::size_t begin = 0; begin < times_.size(); begin += stretch) {
    const std::size_t end = std::min(begin + stretch, times_.size());
    times.push_back(times_[end - 1]);
    for (std::size_t b = 0; b < columns_.size(); ++b) {
      double largest = 0.0;
      for (std::size_t row = begin; row < end; ++row) {
        const double* const force = values_.data() + row_width * (row * columns_.size() + b);
        largest = std::max(largest, std::hypot(force[0], force[1], force[2]));
      }
      bodies[b].push_back(largest);
    }
  }
  return {{"times", std::move(times)}, {"bodies", std::move(bodies)}};
}

}  // namespace palpate::view
