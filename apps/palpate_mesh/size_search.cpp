#include "size_search.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace palpate::app {

void SizeSearch::add(double size, double off) {
  tried_.emplace_back(std::log(size), off);
}

bool SizeSearch::coarser_does_not_help() const {
  constexpr double much_coarser = 0.2;  // logarithms
  constexpr double hardly_fewer = 0.1;
  if (tried_.size() < 2) return false;
  const auto [size, off] = tried_.back();
  const auto [before, off_before] = tried_[tried_.size() - 2];
  return off > 0.0 && size > before + much_coarser && off > off_before - hardly_fewer;
}

double SizeSearch::next() const {
  constexpr double power = -2.6;  // exponent p of tets ~ size^p: -3 in thick organs, -2 in thin ones
  double slope = power;
  const auto [size, off] = tried_.back();
  if (tried_.size() >= 2) {
    const auto [before, off_before] = tried_[tried_.size() - 2];
    slope = std::clamp((off - off_before) / (size - before), -4.0, -1.5);
  }
  double next = size - off / slope;
  double low = -1e300;
  double high = 1e300;
  for (const auto& [s, o] : tried_) (o > 0.0 ? low : high) = o > 0.0 ? std::max(low, s) : std::min(high, s);
  if (low < high && (next <= low || next >= high)) next = 0.5 * (low + high);
  return std::exp(next);
}

std::optional<std::string> missed_number(double tets, double wanted) {
  constexpr double far = 1.1;
  if (tets < far * wanted && wanted < far * tets) return std::nullopt;
  return fmt::format("{:.0f} tets, where {:.0f} were asked for: no size tried gives a nearer number", tets,
                     wanted);
}

}  // namespace palpate::app
