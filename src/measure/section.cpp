#include "measure/section.hpp"

namespace palpate::measure {

using Json = nlohmann::ordered_json;

nlohmann::ordered_json to_json(const Section& section) {
  Json charts = Json::array();
  for (const Chart& chart : section.charts) {
    Json series = Json::array();
    for (const Series& line : chart.series)
      series.push_back({{"name", line.name}, {"x", line.x}, {"y", line.y}});
    charts.push_back({{"title", chart.title},
                      {"x_label", chart.x_label},
                      {"y_label", chart.y_label},
                      {"logarithmic", chart.logarithmic},
                      {"series", std::move(series)}});
  }
  return {{"id", section.id},
          {"title", section.title},
          {"paper", section.paper},
          {"ours", section.ours},
          {"verdict", verdict_names[static_cast<std::size_t>(section.verdict)]},
          {"why", section.why},
          {"table", {{"columns", section.table.columns}, {"rows", section.table.rows}}},
          {"charts", std::move(charts)}};
}

}  // namespace palpate::measure
