#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::measure {

/// Whether a measurement says what the paper says.
enum class Verdict { agrees, differs, not_comparable };
inline constexpr std::array<std::string_view, 3> verdict_names{"agrees", "differs", "not comparable"};

/// A line of a chart; `y` at `x`.
struct Series {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
};

struct Chart {
  std::string title{};
  std::string x_label{};  ///< with the unit
  std::string y_label{};
  bool logarithmic = false;  ///< both axes
  std::vector<Series> series{};
};

/// A table: cells are numbers or texts.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<nlohmann::ordered_json>> rows;
};

/// An item of the report: what the paper did and found, what we did, our figures, and what that says.
struct Section {
  std::string id{};
  std::string title{};
  std::string paper{};
  std::string ours{};
  Verdict verdict = Verdict::not_comparable;
  std::string why{};
  Table table{};
  std::vector<Chart> charts{};
};

nlohmann::ordered_json to_json(const Section& section);

}  // namespace palpate::measure
