#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::measure {

/// Whether a measurement agrees with the paper.
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

/// Times in ms of one operation, and how many there are; used to compare two reports.
struct Measure {
  std::string name;
  bool reference = false;  ///< work outside of our code: shows the speed of the machine
  std::size_t samples = 0;
  double least = 0.0;
  double lower_quartile = 0.0;
  double median = 0.0;
  double upper_quartile = 0.0;
  double most = 0.0;
};

/// The measure of times in ms, in any order; at least one.
Measure measure_of(std::string name, std::vector<double> milliseconds, bool reference = false);

/// An item of the report: what the paper did and found, what we did, our figures, and the verdict.
struct Section {
  std::string id{};
  std::string title{};
  std::string paper{};  ///< what the paper found; empty if it has nothing on this
  std::string ours{};
  Verdict verdict = Verdict::not_comparable;
  std::string why{};
  Table table{};
  std::vector<Chart> charts{};
  std::vector<Measure> measures{};
  std::string
      result_hash{};  ///< hash of the results, the same on every machine; empty if there is nothing to hash
};

nlohmann::ordered_json to_json(const Section& section);

/// The hash as 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace palpate::measure
