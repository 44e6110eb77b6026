#pragma once

#include <nlohmann/json.hpp>

#include "run_report.hpp"

namespace palpate::app {

/// The content of outcomes.json: of each outcome its value at the end, its unit, its definition, and its
/// values at the ends of stages.
nlohmann::ordered_json outcomes_json(const RunReport& report);

/// The stages of a run that are over, for run.json and outcomes.json.
nlohmann::ordered_json stages_json(const RunReport& report);

}  // namespace palpate::app
