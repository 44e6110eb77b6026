#include "speed/rows.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <optional>
#include <stdexcept>

namespace palpate::bench {
namespace {

using Json = nlohmann::ordered_json;

/// A row without its goal.
struct Measured {
  std::string work;
  std::string unit;  ///< of ours and other
  double ours = 0.0;
  double other = 0.0;
  std::string other_side;
  double ratio = 0.0;  ///< what the goal bounds
};

bool reaches(const Goal& goal, double ratio, double bound) {
  return goal.at_most ? ratio <= bound : ratio >= bound;
}

Json with_verdict(const Measured& row) {
  const auto* const goal = std::ranges::find(goals, row.work, &Goal::work);
  if (goal == std::end(goals)) throw std::logic_error("no goal for '" + row.work + "'");
  const char* verdict = reaches(*goal, row.ratio, goal->aim)    ? "aim met"
                        : reaches(*goal, row.ratio, goal->must) ? "met"
                                                                : "missed";
  return {{"table", goal->table}, {"work", row.work},         {"ours", row.ours},
          {"other", row.other},   {"unit", row.unit},         {"other_side", row.other_side},
          {"ratio", row.ratio},   {"ratio_unit", goal->unit}, {"must", goal->must},
          {"aim", goal->aim},     {"at_most", goal->at_most}, {"verdict", verdict}};
}

/// Ratio of the other's time to ours.
Measured faster(std::string work, double ours, double other, std::string other_side) {
  return {std::move(work), "ms", ours, other, std::move(other_side), other / ours};
}

/// The least of the values whose key begins so, and the rest of its key.
std::optional<std::pair<std::string, double>> least(const Json& values, std::string_view prefix) {
  std::optional<std::pair<std::string, double>> result;
  for (const auto& [key, value] : values.items()) {
    if (!key.starts_with(prefix)) continue;
    if (!result || value.get<double>() < result->second)
      result = {key.substr(prefix.size()), value.get<double>()};
  }
  return result;
}

const Json* named(const Json& cases, std::string_view name) {
  for (const Json& c : cases)
    if (c.at("name") == name) return &c;
  return nullptr;
}

bool has_goal(const std::string& work) {
  return std::ranges::find(goals, work, &Goal::work) != std::end(goals);
}

void add_contacts(const Json& c, Json& rows) {
  const std::string name = c.at("name");
  const Json& times = c.at("median_ms");
  const auto embree = least(times, "Embree: ");
  if (!embree) return;
  const std::string side = "Embree, " + embree->first;
  const auto add = [&](const std::string& work, const char* method) {
    if (has_goal(work) && times.contains(method))
      rows.push_back(with_verdict(faster(work, times[method], embree->second, side)));
  };
  add("contacts, " + name, "clustered");
  add("contacts with coherence, " + name, "coherent");
}

void add_two_threads(const Json& c, Json& rows) {
  const std::string work = "contacts, 2 threads against 1, " + c.at("name").get<std::string>();
  const Json& times = c.at("smallest_ms");
  if (!has_goal(work) || !times.contains("clustered, 2 threads")) return;
  rows.push_back(
      with_verdict(faster(work, times["clustered, 2 threads"], times.at("clustered, 1 thread"), "1 thread")));
}

void add_targets(const Json& c, Json& rows) {
  const std::string work = "contacts, AVX2 against AVX-512, " + c.at("name").get<std::string>();
  const Json& times = c.at("median_ms");
  const bool is_avx_512 = c.value("best_target", "AVX3").starts_with("AVX3");
  if (!has_goal(work) || !is_avx_512 || !times.contains("clustered, AVX2")) return;
  const double avx2 = times["clustered, AVX2"];
  const double best = times.at("clustered");
  rows.push_back(with_verdict({work, "ms", avx2, best, "AVX-512", 100.0 * best / avx2}));
}

void add_growth(const Json& cases, Json& rows) {
  const Json* const small = named(cases, "stacking 10000");
  const Json* huge = nullptr;
  for (const Json& c : cases)
    if (c.at("tets").get<double>() > 5e6) huge = &c;
  if (small == nullptr || huge == nullptr) return;
  const auto each = [](const Json& c) {
    return 1e6 * c.at("median_ms").at("clustered").get<double>() / c.at("tets").get<double>();
  };
  rows.push_back(with_verdict({"contacts, ns a tet with 10 million against 10000", "ns", each(*huge),
                               each(*small), "10000 tets", each(*huge) / each(*small)}));
}

}  // namespace

Json query_rows(const Json& cases) {
  Json rows = Json::array();
  for (const auto& add : {add_contacts, add_two_threads, add_targets})
    for (const Json& c : cases) add(c, rows);
  add_growth(cases, rows);
  return rows;
}

Json handling_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    const std::string name = c.at("name");
    if (const auto edges = c.find("border_edges"); edges != c.end()) {
      rows.push_back(with_verdict(faster("border edges against triangles, " + name, edges->at("ms"),
                                         edges->at("embree_ms"),
                                         "Embree, " + edges->at("embree_mode").get<std::string>())));
    }
    for (const auto& [key, work] : {std::pair("clustered", "whole collision handling"),
                                    std::pair("points alone", "handling of points alone")}) {
      const auto whole = c.find(key);
      if (whole == c.end()) continue;
      const double all = whole->at("all_ms");
      const double contacts = whole->at("contacts_ms");
      rows.push_back(with_verdict({fmt::format("{} relative to its contact query, {}", work, name), "ms", all,
                                   contacts, "its contacts", all / contacts}));
    }
    if (const auto rest = c.find("at_rest"); rest != c.end()) {
      const double with = rest->at("coherent").at("all_ms");
      const double without = rest->at("clustered").at("all_ms");
      rows.push_back(with_verdict({"handling at rest, with coherence relative to without, " + name, "ms",
                                   with, without, "without coherence", 100.0 * with / without}));
    }
  }
  return rows;
}

Json threads_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    const Json& one = c.at("times").at(0);
    const Json& two = c.at("times").at(1);
    for (const auto& [work, key] : {std::pair("whole detection", "all"), std::pair("whole step", "all"),
                                    std::pair("update of the grid", "grid")}) {
      const std::string row =
          fmt::format("{}, 2 threads against 1, {}", work, c.at("name").get<std::string>());
      if (!has_goal(row)) continue;
      const Json& measured = two.at(key);
      rows.push_back(with_verdict(
          {row, "ms", measured.at("ms"), one.at(key).at("ms"), "1 thread", measured.at("faster")}));
    }
  }
  return rows;
}

Json movers_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    const std::string work = "adding 2 % movers, 128k entries, against ";
    const double ours = c.at("repair_ms");
    const double copy = c.at("memcpy_ms");
    rows.push_back(with_verdict({work + "memcpy", "ms", ours, copy, "memcpy of as many bytes", ours / copy}));
    rows.push_back(with_verdict(faster(work + "std::sort", ours, c.at("std_sort_last_order_ms"),
                                       "std::sort from last frame's order")));
  }
  return rows;
}

Json dynamics_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    const Json& eigen = c.at("eigen");
    rows.push_back(with_verdict(faster("rotations, forces, assembly: " + c.at("name").get<std::string>(),
                                       c.at("update_ms"), eigen.at("update_ms"), "Eigen")));
  }
  for (const Json& c : cases) {
    const Json& eigen = c.at("eigen");
    Json times;
    for (const auto& [key, run] : c.at("solve").items()) times[key] = run.at("ms");
    const auto best = least(times, "");
    rows.push_back(with_verdict(faster(
        "time to an error of 1e-3: " + c.at("name").get<std::string>(), best->second, eigen.at("solve_ms"),
        fmt::format("Eigen, {}; ours {}", eigen.at("preconditioner").get<std::string>(), best->first))));
  }
  for (const Json& c : cases) {
    const double ours = c.at("product").at("GB_per_s");
    const double read = c.at("product").at("read_GB_per_s");
    rows.push_back(with_verdict(
        {"product with the matrix relative to reading as much memory: " + c.at("name").get<std::string>(),
         "GB/s", ours, read, "reading", 100.0 * ours / read}));
  }
  return rows;
}

Json step_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    rows.push_back(with_verdict(faster("step of 25 iterations: " + c.at("name").get<std::string>(),
                                       c.at("fixed").at("ms"), c.at("sofa_scaled_ms"), "SOFA, scaled")));
  }
  for (const Json& c : cases) {
    Json times;
    for (const auto& [key, run] : c.at("converged").items()) times[key] = run.at("ms");
    const auto best = least(times, "");
    rows.push_back(
        with_verdict(faster("step to an error of 1e-3: " + c.at("name").get<std::string>(), best->second,
                            c.at("sofa_scaled_ms"), "SOFA unconverged, scaled; ours " + best->first)));
  }
  return rows;
}

Json tissue_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    const double ours = c.at("neo_hookean_ms");
    const double other = c.at("corotational_ms");
    rows.push_back(with_verdict({"stable neo-Hookean over corotational: " + c.at("name").get<std::string>(),
                                 "ms", ours, other, "corotational", ours / other}));
  }
  return rows;
}

Json instructions_rows(const Json& cases) {
  Json rows = Json::array();
  for (const Json& c : cases) {
    const std::string name = c.at("name");
    const std::string unit = c.at("unit");
    const std::string work = fmt::format("{}, instructions per {}", name, unit);
    if (!has_goal(work)) continue;
    const double units = c.at("units");
    rows.push_back(with_verdict({work, "M", c.at("instructions").get<double>() / 1e6, units / 1e6,
                                 "units of work", c.at("per_unit")}));
  }
  for (const Json& c : cases) {
    const std::string work = "parallel part of the instructions, " + c.at("name").get<std::string>();
    if (!has_goal(work)) continue;
    const Json& parallel = c.at("parallel");
    constexpr double million = 1e6;
    rows.push_back(with_verdict({work, "M", parallel.at("longest_chain").get<double>() / million,
                                 c.at("instructions").get<double>() / million, "all instructions",
                                 100.0 * parallel.at("share").get<double>()}));
  }
  return rows;
}

double machine_scale(const Json& references) {
  std::array<double, 3> ratios{23.0 / references.at("memcpy_GB_per_s").get<double>(),
                               references.at("sort_ms").get<double>() / 68.0,
                               references.at("multiply_add_ms").get<double>() / 70.0};
  std::ranges::sort(ratios);
  return ratios[1];
}

std::string table_text(const Json& rows) {
  std::string text;
  for (const std::string_view table : table_names) {
    std::string lines;
    for (const Json& row : rows) {
      if (row.at("table") != table) continue;
      const std::string unit = row.at("ratio_unit");
      const auto with_unit = [&](const char* key) {
        return fmt::format("{:.3g}{}", row.at(key).get<double>(), unit);
      };
      const char* bound = row.at("at_most").get<bool>() ? "≤ " : "≥ ";
      lines += fmt::format("{:<62} {:>9.4g} {:>9.4g} {:<4} {:>8} {:>8} {:>8}  {:<8} {}\n",
                           row.at("work").get<std::string>(), row.at("ours").get<double>(),
                           row.at("other").get<double>(), row.at("unit").get<std::string>(),
                           with_unit("ratio"), bound + with_unit("must"), bound + with_unit("aim"),
                           row.at("verdict").get<std::string>(), row.at("other_side").get<std::string>());
    }
    if (lines.empty()) continue;
    text += fmt::format("{:<62} {:>9} {:>9} {:<4} {:>8} {:>8} {:>8}  {:<8} {}\n{}\n", table, "ours", "other",
                        "", "ratio", "must", "aim", "", "the other side", lines);
  }
  return text;
}

}  // namespace palpate::bench
