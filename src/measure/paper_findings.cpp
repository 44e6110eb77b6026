#include <algorithm>
#include <fmt/format.h>

#include "measure/paper.hpp"

namespace palpate::measure {
namespace {

Verdict agreement(bool agrees) {
  return agrees ? Verdict::agrees : Verdict::differs;
}

std::string fraction_text(double speed_up, int threads) {
  if (speed_up <= 1.0) return "none";
  return fmt::format("{:.0f} %", 100.0 * parallel_fraction(speed_up, threads));
}

/// The range of a ratio over the scenes as text: "0.92 to 1.20 times".
template <class Of>
std::string range_of(const std::vector<StructureFigures>& scenes, const char* format, Of&& of) {
  const auto [least, most] = std::ranges::minmax(scenes, {}, of);
  const std::string low = fmt::format(fmt::runtime(format), of(least));
  const std::string high = fmt::format(fmt::runtime(format), of(most));
  return low == high ? low : low + " to " + high;
}

}  // namespace

Finding eye_finding(double insertion, double index_speed_up, double cuckoo_speed_up, int threads) {
  std::string why = fmt::format(
      "cuckoo hashing takes {:.1f} times as long as index sort to insert on one thread", insertion);
  const bool faster = insertion > 1.0;
  if (threads == 1) {
    why += "; how they scale cannot be seen on one thread";
    return {faster ? Verdict::not_comparable : Verdict::differs, why};
  }
  const bool scales = index_speed_up >= cuckoo_speed_up;
  why += fmt::format(
      "; index sort scales {} than cuckoo hashing: parallel fractions {} and {} with {} threads (paper: 80 % "
      "and 70 % with eight)",
      index_speed_up > cuckoo_speed_up ? "better"
      : scales                         ? "no worse"
                                       : "worse",
      fraction_text(index_speed_up, threads), fraction_text(cuckoo_speed_up, threads), threads);
  return {agreement(faster && scales), why};
}

Finding cell_size_finding(const std::vector<CellSizeFigures>& scenes) {
  constexpr double noise = 1.03;
  std::size_t best = 0;
  std::string why;
  for (const CellSizeFigures& scene : scenes) {
    if (scene.mean_edge <= noise) ++best;
    const double ratio = scene.automatic / scene.mean_edge;
    why += fmt::format(
        "{}: the best size is {}; the mean edge takes {:.2f} times as long, auto {:.2f} times ({}); ",
        scene.scene, scene.best, scene.mean_edge, scene.automatic,
        ratio > noise         ? fmt::format("slower than the mean edge by {:.0f} %", 100.0 * (ratio - 1.0))
        : ratio < 1.0 / noise ? fmt::format("faster than the mean edge by {:.0f} %", 100.0 * (1.0 - ratio))
                              : "as fast as the mean edge");
  }
  why += fmt::format("the mean edge is within 3 % of the best in {} of {} scenes", best, scenes.size());
  return {agreement(2 * best > scenes.size()), why};
}

Finding structures_finding(const std::vector<StructureFigures>& scenes, std::size_t second_tries) {
  const bool all_less = std::ranges::all_of(scenes, [](const StructureFigures& s) {
    return s.compact < s.uniform && s.hash < s.uniform && s.cuckoo < s.uniform;
  });
  const auto fraction = [&](double StructureFigures::*structure) {
    return range_of(scenes, "{:.2f}", [&](const StructureFigures& s) { return s.*structure / s.uniform; });
  };
  return {agreement(all_less && second_tries == 0),
          fmt::format(
              "compact grids take {}, hashing {} and cuckoo hashing {} times the memory of uniform grids; "
              "cuckoo tables are {} % full (paper: 71 %) and needed {} retries",
              fraction(&StructureFigures::compact), fraction(&StructureFigures::hash),
              fraction(&StructureFigures::cuckoo),
              range_of(scenes, "{:.0f}", [](const StructureFigures& s) { return 100.0 * s.occupancy; }),
              second_tries)};
}

Finding errors_finding(const std::vector<ErrorFigures>& scenes) {
  constexpr double tolerable = 0.1;  // cm
  std::string why;
  double largest = 0.0;
  double largest_mean = 0.0;
  bool fewer_faster = true;
  bool pays = false;
  for (const ErrorFigures& scene : scenes) {
    largest = std::max(largest, scene.largest);
    largest_mean = std::max(largest_mean, scene.largest_mean);
    fewer_faster = fewer_faster && scene.with_8 < scene.with_27 && scene.with_1 < scene.with_27;
    const double fastest = std::min({scene.with_27, scene.with_8, scene.with_1});
    pays = pays || fastest < scene.exact;
    why += fmt::format(
        "{}: {:.2f} times as fast with 8 cells as with 27, {:.2f} times with 1 cell; the exact query is "
        "{:.2f} times as fast as the fastest of these; ",
        scene.scene, scene.with_27 / scene.with_8, scene.with_27 / scene.with_1, fastest / scene.exact);
  }
  const auto place = [](double deviation) { return deviation < tolerable ? "below" : "above"; };
  why +=
      fmt::format("{}largest deviation {:.2g} cm, {} the tolerable 1 mm, largest average {:.2g} cm, {} it",
                  pays ? "" : "the approximate mode does not pay here: the exact query is faster than all; ",
                  largest, place(largest), largest_mean, place(largest_mean));
  return {agreement(fewer_faster && largest_mean < tolerable), why};
}

}  // namespace palpate::measure
