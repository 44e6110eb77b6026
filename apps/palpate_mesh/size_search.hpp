#pragma once

#include <utility>
#include <vector>

namespace palpate::app {

/// Finds the size at which a mesh has so many tets: secants in logarithms.
class SizeSearch {
 public:
  /// A try: the size and the logarithm of its tets over those that are wanted.
  void add(double size, double off);
  /// A shape of many thin necks takes as many tets at any size.
  [[nodiscard]] bool coarser_does_not_help() const;
  /// Where the line through the last two tries meets the wanted number; between the nearest tries on both
  /// sides where there are any, so that the search cannot run away. Needs a try.
  [[nodiscard]] double next() const;

 private:
  std::vector<std::pair<double, double>> tried_;  ///< logarithms of size, and of tets over what is wanted
};

}  // namespace palpate::app
