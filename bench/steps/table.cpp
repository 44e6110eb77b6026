#include "steps/table.hpp"

#include <cmath>
#include <fmt/format.h>

namespace palpate::bench {
namespace {

constexpr const char* line_format =
    "{:<24}{:>8}{:>6}{:>12}{:>14}{:>6}{:>9}{:>9}{:>6}{:>8}{:>9}{:>9}{:>10}{:>11}  {:<5}{}\n";

/// Three digits, and no exponent that people have to count.
std::string text(double value) {
  if (value == 0.0) return "0";
  if (std::abs(value) >= 100.0 && std::abs(value) < 1e7) return fmt::format("{:.0f}", value);
  return fmt::format("{:.3g}", value);
}

std::string mean_and_most(const Json& tally) {
  return fmt::format("{} ({})", text(tally.at("mean").get<double>()), tally.at("most").get<std::int64_t>());
}

std::string line(const Json& row) {
  const auto number = [&](const char* key) { return row.at(key).get<double>(); };
  return fmt::format(
      line_format, row.at("name").get<std::string>(), row.at("tets").get<std::size_t>(),
      row.at("steps").get<int>(), mean_and_most(row.at("solves")), mean_and_most(row.at("iterations")),
      text(row.at("detections").at("mean").get<double>()), text(number("work")), text(number("ms")),
      fmt::format("{:.0f} %", 100.0 * number("solver_share")), row.at("divided").get<int>(),
      row.at("not_converged").get<int>(), row.at("inverted_tets").at("most").get<std::int64_t>(),
      text(row.at("deepest_um").at("last").get<double>()), text(number("fastest_body_mm_s")),
      row.at("at_rest").get<bool>() ? "rest" : "", row.at("state_hash").get<std::string>());
}

}  // namespace

std::string steps_table(const Json& report) {
  std::string all =
      fmt::format(line_format, "scene", "tets", "steps", "solves", "iterations", "det.", "work", "ms",
                  "solve", "divided", "not conv", "inverted", "deepest", "fastest", "rest", "hash");
  for (const Json& row : report.at("rows")) {
    if (row.contains("steps")) all += line(row);
    if (row.contains("position_error")) {
      all += fmt::format("{:<24}from the reference: {:.2g} edges at most, {:.2g} root mean square\n", "",
                         row.at("position_error").at("largest").get<double>(),
                         row.at("position_error").at("rms").get<double>());
    }
    if (!row.at("error").is_null())
      all += fmt::format("{:<24}FAILED: {}\n", row.at("name").get<std::string>(),
                         row.at("error").get<std::string>());
  }
  for (const Json& absent : report.at("left_out")) {
    all += fmt::format("{:<24}left out: {}\n", absent.at("name").get<std::string>(),
                       absent.at("reason").get<std::string>());
  }
  return all +
         "\nsolves, iterations: mean of a step (most); det.: detections of a step; work: products with the "
         "matrix "
         "that the solver's time of a step is as long as;\nms of a step and the solver's part; steps "
         "divided; steps not "
         "converged; inverted tets, most; at the end: deepest contact (um), fastest body (mm/s)\n";
}

}  // namespace palpate::bench
