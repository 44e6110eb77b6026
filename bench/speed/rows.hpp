#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

/// The tables of our goals: detection, dynamics and whole steps.
namespace palpate::bench {

inline constexpr std::array<std::string_view, 3> table_names{"detection", "dynamics", "whole"};

/// A row of these tables with our own goals: a ratio that must be reached, and one that we aim at.
struct Goal {
  std::string_view table;
  std::string_view work;
  double must = 0.0;
  double aim = 0.0;
  std::string_view unit = "×";  ///< of the ratio: "×" or "%"
  bool at_most = false;         ///< both are upper bounds
};

// All goals are defined here.
inline constexpr Goal goals[] = {
    {"detection", "contacts, stacking 10000", 27, 40},
    {"detection", "contacts, stacking 102400", 24, 35},
    {"detection", "contacts, stacking 1000000", 18, 30},
    {"detection", "contacts with coherence, stacking 10000", 50, 80},
    {"detection", "contacts with coherence, stacking 1000000", 28, 50},
    {"detection", "contacts, pile", 18, 30},
    {"detection", "contacts, tubes", 18, 30},
    {"detection", "contacts, raptors", 18, 30},
    {"detection", "contacts, eye", 18, 30},
    {"detection", "contacts, skull", 18, 30},
    {"detection", "contacts, self-collision", 20, 30},
    {"detection", "contacts, 2 threads against 1, stacking 10000", 1.5, 1.8},
    {"detection", "contacts, 2 threads against 1, stacking 1000000", 1.85, 1.95},
    {"detection", "contacts, AVX2 against AVX-512, stacking 10000", 55, 75, "%"},
    {"detection", "border edges against triangles, stacking 10000", 7.5, 15},
    {"detection", "adding 2 % movers, 128k entries, against memcpy", 6, 3, "×", true},
    {"detection", "adding 2 % movers, 128k entries, against std::sort", 30, 45},
    {"detection", "whole collision handling relative to its contact query, stacking 10000", 5, 2.5, "×",
     true},
    {"detection", "handling of points alone relative to its contact query, stacking 10000", 5, 2.5, "×",
     true},
    {"detection", "handling at rest, with coherence relative to without, stacking 10000", 50, 20, "%", true},
    {"detection", "depth, instructions per contact", 2000, 1000, "", true},
    {"detection", "crossings, instructions per border edge", 450, 250, "", true},
    {"detection", "parallel part of the instructions, whole detection", 90, 97, "%"},
    {"detection", "whole detection, 2 threads against 1, stacking 10000", 1.6, 1.8},
    {"detection", "whole detection, 2 threads against 1, stacking 102400", 1.8, 1.9},
    {"detection", "whole detection, 2 threads against 1, stacking 1000000", 1.85, 1.95},
    {"detection", "update of the grid, 2 threads against 1, stacking 10000", 1, 1.5},
    {"detection", "update of the grid, 2 threads against 1, stacking 102400", 1, 1.5},
    {"detection", "update of the grid, 2 threads against 1, stacking 1000000", 1, 1.5},
    {"detection", "contacts, ns a tet with 10 million against 10000", 2.3, 1.5, "×", true},
    {"dynamics", "rotations, forces, assembly: stacking", 20, 40},
    {"dynamics", "rotations, forces, assembly: skull", 22, 45},
    {"dynamics", "rotations, forces, assembly: block", 12, 20},
    {"dynamics", "time to an error of 1e-3: stacking", 20, 45},
    {"dynamics", "time to an error of 1e-3: skull", 30, 70},
    {"dynamics", "time to an error of 1e-3: block", 8, 15},
    {"dynamics", "product with the matrix relative to reading as much memory: stacking", 70, 85, "%"},
    {"dynamics", "product with the matrix relative to reading as much memory: skull", 70, 85, "%"},
    {"dynamics", "product with the matrix relative to reading as much memory: block", 70, 85, "%"},
    {"whole", "whole step, 2 threads against 1, falling stack", 1.6, 1.8},
    {"whole", "step of 25 iterations: stacking at rest", 9, 15},
    {"whole", "step of 25 iterations: head", 6, 12},
    {"whole", "step to an error of 1e-3: stacking at rest", 8, 12},
    {"whole", "step to an error of 1e-3: head", 3, 5},
    {"dynamics", "stable neo-Hookean over corotational: element pass", 2.5, 2, "×", true},
    {"whole", "stable neo-Hookean over corotational: step of the eye", 3, 2, "×", true},
    {"whole", "parallel part of the instructions, step of the falling stack", 85, 95, "%"},
};

/// The rows of the cases that each part has measured, with goal and verdict ("aim met", "met", "missed").
/// Rows for which cases are missing are left out.
nlohmann::ordered_json query_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json handling_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json threads_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json movers_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json dynamics_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json step_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json tissue_rows(const nlohmann::ordered_json& cases);
nlohmann::ordered_json instructions_rows(const nlohmann::ordered_json& cases);

/// Scale of times from the machine with known references to this one: the median of three ratios of reference
/// times, ours over theirs, so that an outlier does not matter.
double machine_scale(const nlohmann::ordered_json& references);

/// The tables as text: rows of all parts, table by table.
std::string table_text(const nlohmann::ordered_json& rows);

}  // namespace palpate::bench
