#include "measure/section.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace palpate::measure {
namespace {

using Json = nlohmann::ordered_json;

/// Quantile of a sorted list, interpolated between neighbours.
double quantile(const std::vector<double>& sorted, double fraction) {
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

Json chart_json(const Chart& chart) {
  Json series = Json::array();
  for (const Series& line : chart.series)
    series.push_back({{"name", line.name}, {"x", line.x}, {"y", line.y}});
  return {{"title", chart.title},
          {"x_label", chart.x_label},
          {"y_label", chart.y_label},
          {"logarithmic", chart.logarithmic},
          {"series", std::move(series)}};
}

Json measure_json(const Measure& measure) {
  return {{"name", measure.name},
          {"reference", measure.reference},
          {"samples", measure.samples},
          {"least", measure.least},
          {"lower_quartile", measure.lower_quartile},
          {"median", measure.median},
          {"upper_quartile", measure.upper_quartile},
          {"most", measure.most}};
}

}  // namespace

Measure measure_of(std::string name, std::vector<double> milliseconds, bool reference) {
  std::ranges::sort(milliseconds);
  return {.name = std::move(name),
          .reference = reference,
          .samples = milliseconds.size(),
          .least = milliseconds.front(),
          .lower_quartile = quantile(milliseconds, 0.25),
          .median = quantile(milliseconds, 0.5),
          .upper_quartile = quantile(milliseconds, 0.75),
          .most = milliseconds.back()};
}

std::string hash_text(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

Json to_json(const Section& section) {
  Json charts = Json::array();
  for (const Chart& chart : section.charts) charts.push_back(chart_json(chart));
  Json measures = Json::array();
  for (const Measure& measure : section.measures) measures.push_back(measure_json(measure));
  return {{"id", section.id},
          {"title", section.title},
          {"paper", section.paper},
          {"ours", section.ours},
          {"verdict", verdict_names[static_cast<std::size_t>(section.verdict)]},
          {"why", section.why},
          {"result_hash", section.result_hash},
          {"table", {{"columns", section.table.columns}, {"rows", section.table.rows}}},
          {"charts", std::move(charts)},
          {"measures", std::move(measures)}};
}

}  // namespace palpate::measure
