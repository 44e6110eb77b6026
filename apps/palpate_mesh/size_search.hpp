#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace palpate::app {

/// Finds the size at which a mesh has a wanted number of tets, by the secant method in logarithms.
class SizeSearch {
 public:
  /// Adds a result.
  /// \param off  logarithm of the number of tets over the wanted number
  void add(double size, double off);
  /// Whether larger sizes no longer give fewer tets, as in a shape of many thin necks.
  [[nodiscard]] bool coarser_does_not_help() const;
  /// The next size to try: where the line through the last two results meets the wanted number, kept between
  /// the nearest results on both sides where there are any, so that the search cannot diverge. Needs one
  /// result.
  [[nodiscard]] double next() const;

 private:
  std::vector<std::pair<double, double>>
      tried_;  ///< logarithms of the size, and of the number of tets over the wanted number
};

/// What to tell the user where a search misses the wanted number of tets by over a tenth.
[[nodiscard]] std::optional<std::string> missed_number(double tets, double wanted);

}  // namespace palpate::app
