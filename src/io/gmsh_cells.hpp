#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::io {

/// A kind of element of Gmsh.
struct GmshCellType {
  std::int64_t number;    ///< as it stands in the file
  std::string_view kind;  ///< our word for it; "tetrahedron" for the four-point tet
  int nodes;
};

/// The kind of an element type number, or nullptr if the manual does not list it.
const GmshCellType* gmsh_cell_type(std::int64_t number);

/// Maps node numbers of a Gmsh file, which may have gaps and any order, to indices of points.
class GmshNodeNumbers {
 public:
  void reserve(std::size_t count) { numbers_.reserve(count); }
  /// The number of the next point.
  void add(std::int64_t number);
  /// Call once after the last add(). Throws Error (source, "node N") if two points have one number. O(n log
  /// n), O(n) for ascending numbers.
  void finish(const std::string& source);
  /// Index of the point of that number, -1 if there is none. O(1), or O(log n) where the range of numbers is
  /// much larger than their count.
  [[nodiscard]] Index find(std::int64_t number) const;

 private:
  std::vector<std::pair<std::int64_t, Index>> numbers_;  ///< (number, index), ascending after finish()
  std::vector<Index>
      table_;  ///< index by number minus the lowest number; empty where gaps would make it too long
};

}  // namespace palpate::io
