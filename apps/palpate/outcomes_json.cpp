#include "outcomes_json.hpp"

#include "geometry/vector.hpp"
#include "numbers.hpp"
#include "scene/json_text.hpp"

namespace palpate::app {
namespace {

using Json = nlohmann::ordered_json;

Json value_json(const OutcomeValue& outcome) {
  Json json{{"value", outcome.value}};
  if (outcome.vector) json["vector"] = to_json(*outcome.vector);
  return json;
}

Json outcome_json(const RunReport& report, std::size_t i, const Json& definition) {
  const OutcomeInfo& info = report.outcomes.infos()[i];
  Json json{{"name", info.name}, {"kind", info.kind}};
  json.update(value_json(report.outcome.outcomes[i]));
  json["unit"] = report.outcomes.unit(i);
  json["in_words"] = report.outcomes.in_words(i, report.outcome.outcomes[i].value);
  json["step"] = report.outcome.steps;
  json["time"] = report.simulation.metrics().time;
  const auto& stages = report.outcome.stages;
  const bool at_end = !stages.empty() && stages.back().last_step == report.outcome.steps;
  json["stage"] = at_end ? Json(stages.back().name) : Json();
  json["definition"] = definition;
  json["stages"] = Json::array();
  for (const StageRecord& stage : stages) {
    if (i >= stage.outcomes.size()) continue;
    Json at_stage{{"stage", stage.name}, {"step", stage.last_step}, {"time", stage.time}};
    at_stage.update(value_json(stage.outcomes[i]));
    json["stages"].push_back(std::move(at_stage));
  }
  return json;
}

}  // namespace

Json stages_json(const RunReport& report) {
  Json list = Json::array();
  const auto name = [&](Index body) { return at(report.simulation.bodies().bodies(), body).name; };
  for (const StageRecord& stage : report.outcome.stages) {
    Json overlaps = Json::array();
    for (const PlacedOverlap& overlap : stage.overlaps) {
      overlaps.push_back({{"bodies", {name(overlap.placed), name(overlap.other)}},
                          {"contacts", overlap.contacts},
                          {"deepest", overlap.deepest}});
    }
    list.push_back({{"name", stage.name},
                    {"first_step", stage.first_step},
                    {"last_step", stage.last_step},
                    {"time", stage.time},
                    {"reached", stage.reached},
                    {"steps_not_converged", stage.steps_not_converged},
                    {"inverted_tets", stage.inverted_tets},
                    {"state_hash", stage.state_hash},
                    {"overlaps", std::move(overlaps)}});
  }
  return list;
}

Json outcomes_json(const RunReport& report) {
  const Json scene = Json::parse(write_scene(report.scene));
  Json json{{"scene", report.scene.name},
            {"state_hash", report.simulation.state_hash()},
            {"stages", stages_json(report)},
            {"outcomes", Json::array()}};
  for (std::size_t i = 0; i < report.outcome.outcomes.size(); ++i)
    json["outcomes"].push_back(outcome_json(report, i, scene["outcomes"][i]));
  return json;
}

}  // namespace palpate::app
