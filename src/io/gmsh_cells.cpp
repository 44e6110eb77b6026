#include "io/gmsh_cells.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

// Element types (Gmsh reference manual, "MSH file format").
constexpr std::array<GmshCellType, 33> gmsh_cell_types{{{1, "line", 2},
                                                        {2, "triangle", 3},
                                                        {3, "quad", 4},
                                                        {4, "tetrahedron", 4},
                                                        {5, "hexahedron", 8},
                                                        {6, "wedge", 6},
                                                        {7, "pyramid", 5},
                                                        {8, "line3", 3},
                                                        {9, "triangle6", 6},
                                                        {10, "quad9", 9},
                                                        {11, "tetrahedron10", 10},
                                                        {12, "hexahedron27", 27},
                                                        {13, "wedge18", 18},
                                                        {14, "pyramid14", 14},
                                                        {15, "vertex", 1},
                                                        {16, "quad8", 8},
                                                        {17, "hexahedron20", 20},
                                                        {18, "wedge15", 15},
                                                        {19, "pyramid13", 13},
                                                        {20, "triangle9", 9},
                                                        {21, "triangle10", 10},
                                                        {22, "triangle12", 12},
                                                        {23, "triangle15", 15},
                                                        {24, "triangle15", 15},
                                                        {25, "triangle21", 21},
                                                        {26, "line4", 4},
                                                        {27, "line5", 5},
                                                        {28, "line6", 6},
                                                        {29, "tetrahedron20", 20},
                                                        {30, "tetrahedron35", 35},
                                                        {31, "tetrahedron56", 56},
                                                        {92, "hexahedron64", 64},
                                                        {93, "hexahedron125", 125}}};

/// high - low; unsigned, because the difference of two int64 may overflow.
std::uint64_t distance(std::int64_t low, std::int64_t high) {
  return static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low);
}

}  // namespace

const GmshCellType* gmsh_cell_type(std::int64_t number) {
  const auto found = std::find_if(gmsh_cell_types.begin(), gmsh_cell_types.end(),
                                  [&](const GmshCellType& type) { return type.number == number; });
  return found == gmsh_cell_types.end() ? nullptr : &*found;
}

void GmshNodeNumbers::add(std::int64_t number) {
  numbers_.emplace_back(number, static_cast<Index>(numbers_.size()));
}

void GmshNodeNumbers::finish(const std::string& source) {
  if (!std::is_sorted(numbers_.begin(), numbers_.end())) std::sort(numbers_.begin(), numbers_.end());
  const auto twice = std::adjacent_find(numbers_.begin(), numbers_.end(),
                                        [](const auto& a, const auto& b) { return a.first == b.first; });
  if (twice != numbers_.end()) {
    throw Error(source, fmt::format("node {}", twice->first), "two nodes with this number",
                "each node number once");
  }
  constexpr std::size_t longest_table =
      8;  // entries per node; if more are needed, a search is better than a table
  if (numbers_.empty()) return;
  const std::uint64_t last = distance(numbers_.front().first, numbers_.back().first);
  if (last / longest_table >= numbers_.size()) return;
  table_.assign(last + 1, -1);
  for (const auto& [number, index] : numbers_) table_[distance(numbers_.front().first, number)] = index;
}

Index GmshNodeNumbers::find(std::int64_t number) const {
  if (numbers_.empty() || number < numbers_.front().first || number > numbers_.back().first) return -1;
  if (!table_.empty()) return table_[distance(numbers_.front().first, number)];
  const auto found = std::lower_bound(numbers_.begin(), numbers_.end(), std::pair{number, Index{0}});
  return found != numbers_.end() && found->first == number ? found->second : -1;
}

}  // namespace palpate::io
