#include "scene/suggest.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <vector>

namespace palpate {
namespace {

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

/// Restricted Damerau-Levenshtein distance (optimal string alignment), by dynamic programming.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> table((a.size() + 1) * width);
  const auto cost = [&](std::size_t i, std::size_t j) -> std::size_t& { return table[i * width + j]; };
  for (std::size_t i = 0; i <= a.size(); ++i) cost(i, 0) = i;
  for (std::size_t j = 0; j <= b.size(); ++j) cost(0, j) = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = lower(a[i - 1]) == lower(b[j - 1]);
      cost(i, j) = std::min({cost(i - 1, j) + 1, cost(i, j - 1) + 1, cost(i - 1, j - 1) + (same ? 0 : 1)});
      const bool swapped =
          i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) cost(i, j) = std::min(cost(i, j), cost(i - 2, j - 2) + 1);
    }
  }
  return cost(a.size(), b.size());
}

bool begin_alike(std::string_view a, std::string_view b) {
  return !a.empty() && !b.empty() && lower(a.front()) == lower(b.front());
}

std::string quoted(std::string_view name) {
  std::string text(1, '\'');
  return text.append(name).append(1, '\'');
}

}  // namespace

std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> known) {
  constexpr std::size_t longest_word = 256;  // longer words are not compared
  if (word.size() > longest_word) return std::nullopt;
  std::optional<std::string_view> best;
  std::size_t best_distance = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string_view name : known) {
    const std::size_t distance = edit_distance(word, name);
    // Words without a common letter are not misspellings of each other: otherwise every single letter would
    // be near to a name of one letter.
    const bool related = distance < std::max(word.size(), name.size());
    const bool better = distance < best_distance || (best && distance == best_distance &&
                                                     begin_alike(word, name) && !begin_alike(word, *best));
    if (related && better) {
      best = name;
      best_distance = distance;
    }
  }
  return best;
}

std::string expected_name(std::string_view word, std::span<const std::string_view> known) {
  if (known.empty()) return "none";
  if (const auto name = nearest_name(word, known)) return quoted(*name);
  std::string list;
  for (auto name = known.begin(); name != known.end(); ++name) {
    // A key that may have values of two kinds is there twice.
    if (std::find(known.begin(), name, *name) == name)
      list.append(list.empty() ? "" : ", ").append(quoted(*name));
  }
  return known.size() == 1 ? list : list.insert(0, "one of ");
}

}  // namespace palpate
