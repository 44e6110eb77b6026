#include "peers/sections.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <map>

#include "measure/report.hpp"
#include "peers/known_modes.hpp"
#include "sim/state_hash.hpp"
#include "stopwatch.hpp"

namespace palpate::bench {
namespace {

using measure::Measure;
using measure::Section;
using Json = nlohmann::ordered_json;

/// All threads and one.
std::vector<int> one_and_all() {
  const int most = measure::thread_counts().back();
  return most > 1 ? std::vector<int>{1, most} : std::vector<int>{1};
}

measure::QueryScene scene_of(const Heat& heat) {
  return heat.cells == 0 ? measure::pile_scene() : measure::stacking_scene(heat.cells, heat.movers);
}

constexpr std::array<const char*, 3> answer_texts{"the same pairs", "own test", "candidates only"};

/// How the answers compare, in words.
std::string comparison(const Performance& p, std::size_t frames) {
  const std::string text = answer_texts[static_cast<std::size_t>(p.answer)];
  if (p.answer == Answer::exact) return text;
  const auto each = [&](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(frames);
  };
  return fmt::format("{}: {:.4g} a frame missing, {:.4g} too many", text, each(p.missing), each(p.extra));
}

/// What a section says in the end.
struct Summary {
  double least_lead = 1e300;  ///< of the fastest peer's time over ours, with as many threads
  double most_lead = 0.0;
  std::string closest;
  void add(const std::string& scene, const std::vector<Measure>& medians,
           const std::vector<Performance>& performances) {
    for (std::size_t ours = 0; ours < performances.size(); ++ours) {
      if (performances[ours].name != "Palpate") continue;
      for (std::size_t i = 0; i < performances.size(); ++i) {
        const bool other = performances[i].name != "Palpate";
        // One thread of those who have no more stands against all of ours.
        if (!other || performances[i].threads != performances[ours].threads) continue;
        const double lead = medians[i].median / medians[ours].median;
        most_lead = std::max(most_lead, lead);
        if (lead < least_lead) {
          least_lead = lead;
          closest = fmt::format("{} ({}, {} thread{})", performances[i].name, scene, performances[i].threads,
                                performances[i].threads == 1 ? "" : "s");
        }
      }
    }
  }
};

void add_rows(Section& section, const measure::QueryScene& scene, const std::string& name,
              const ContestResult& result, std::map<std::string, measure::Series>& lines, bool in_chart,
              Summary& summary) {
  std::vector<Measure> medians;
  for (const Performance& p : result.performances)
    medians.push_back(measure::measure_of(fmt::format("{}, {}, {} threads", name, p.name, p.threads),
                                          p.milliseconds, p.name != "Palpate"));
  const auto ours = [&](int threads) {
    for (std::size_t i = 0; i < medians.size(); ++i)
      if (result.performances[i].name == "Palpate" && result.performances[i].threads == threads)
        return medians[i].median;
    return medians.front().median;
  };
  for (std::size_t i = 0; i < medians.size(); ++i) {
    const Performance& p = result.performances[i];
    section.table.rows.push_back(
        {scene.name, 100.0 * result.movers, p.name, p.threads, p.mode, medians[i].least, medians[i].median,
         medians[i].most, medians[i].median / ours(p.threads), comparison(p, result.frames), result.frames});
    if (in_chart && p.threads == 1) {
      measure::Series& line = lines.try_emplace(p.name, measure::Series{p.name, {}, {}}).first->second;
      line.x.push_back(static_cast<double>(scene.bodies.tets().size()));
      line.y.push_back(medians[i].median);
    }
  }
  summary.add(name, medians, result.performances);
  section.measures.insert(section.measures.end(), medians.begin(), medians.end());
}

Section empty_section(Task task) {
  const bool points = task == Task::points_in_tets;
  return {
      .id = points ? "peers-points" : "peers-edges",
      .title = points ? "Peers: points in tets of other bodies" : "Peers: border edges against triangles",
      .ours = std::string(points ? "Palpate puts the points into cells and finds the tets that contain them. "
                                 : "Palpate finds the crossings; all libraries get the border edges. ") +
              "All libraries get the same positions, alternately: the stack of membranes with more and more "
              "cells, and a pile of balls and boxes. Of each library the fastest mode in a trial counts. A "
              "mode that took four times as long as that in a smaller scene is not tried again. Times are "
              "wall times for Palpate and for several threads. For other libraries with one thread they are "
              "processor times, which other work on the machine affects less. They include the time to pass "
              "the positions to the library. Palpate has coherence between frames on, the default; without "
              "it see the table of docs/benchmarks.md, \"What we set out to reach\". Libraries that call our "
              "exact test must find the same pairs; otherwise the benchmark fails.",
      .table = {{"scene", "movers, %", "library", "threads", "mode", "least, ms", "median, ms", "most, ms",
                 "times Palpate", "answers", "frames"},
                {}}};
}

}  // namespace

PeersEffort quick_effort() {
  PeersEffort effort{.heats = {},
                     .contest = {.seconds = 2.5},
                     .threads = one_and_all(),
                     .most_tets_of_trials = 0.0,
                     .python_most_tets = 5e4};
  for (const double movers : {0.02, 0.1, 1.0}) effort.heats.push_back({measure::stacking_cells(1e4), movers});
  effort.heats.push_back({measure::stacking_cells(1e5), 0.02});
  effort.heats.push_back({0, 0.02});
  return effort;
}

PeersEffort full_effort() {
  PeersEffort effort = quick_effort();
  effort.contest = {.seconds = 12.0, .patience = 8.0};
  effort.most_tets_of_trials = 2e5;
  effort.python_most_tets = 1e300;
  for (const double movers : {0.1, 1.0}) effort.heats.push_back({measure::stacking_cells(1e5), movers});
  for (const double movers : {0.02, 0.1, 1.0}) effort.heats.push_back({measure::stacking_cells(1e6), movers});
  return effort;
}

Section contest_section(Task task, const PeersEffort& effort, const PythonPeers& python,
                        std::vector<Absentee>& absent,
                        const std::function<void(const std::string& line)>& tell,
                        const std::function<bool()>& interrupted) {
  Section section = empty_section(task);
  std::map<std::string, measure::Series> lines;
  std::uint64_t hash = fnv1a({});
  Summary summary;
  KnownModes known;
  std::size_t told = 0;
  for (const Heat& heat : effort.heats) {
    if (interrupted()) throw measure::Interrupted{};
    Stopwatch watch;
    const measure::QueryScene scene = scene_of(heat);
    const Course course{scene, scene.immovable(), task};
    std::vector<Entrant> entrants;
    add_ours(course, effort.threads, entrants);
    add_embree(course, effort.threads, entrants);
    add_cgal(course, effort.threads, entrants);
    add_bullet(course, entrants);
    add_vtk(course, effort.threads, entrants);
    std::vector<Absentee> away;
    const std::size_t tets = scene.bodies.tets().size();
    if (static_cast<double>(tets) <= effort.python_most_tets) {
      add_python(python, course, effort.threads, entrants, away);
    } else {
      away.push_back({"IPC Toolkit and PBAT", fmt::format("{}: too slow for a quick run", scene.name)});
    }
    known.leave_out_hopeless(tets, effort.contest.patience, entrants);
    if (static_cast<double>(tets) > effort.most_tets_of_trials) known.leave_fastest(tets, entrants);
    const ContestResult result = run_contest(course, std::move(entrants), effort.contest);
    known.add(result.trials, tets);
    away.insert(away.end(), result.dropped.begin(), result.dropped.end());
    for (Absentee& absentee : away) {
      absentee.name += task == Task::points_in_tets ? ", points in tets" : ", border edges";
      const auto same = [&](const Absentee& a) {
        return a.name == absentee.name && a.reason == absentee.reason;
      };
      if (std::ranges::none_of(absent, same)) absent.push_back(absentee);
    }
    hash = fnv1a(std::as_bytes(std::span(&result.hash, 1)), hash);
    const std::string name = fmt::format("{}, {:.0f} % movers", scene.name, 100.0 * heat.movers);
    const bool in_chart = heat.cells > 0 && heat.movers == 0.02;
    add_rows(section, scene, name, result, lines, in_chart, summary);
    tell(fmt::format("  {} of {}: {}: {} frames, {:.1f} s", ++told, effort.heats.size(), name, result.frames,
                     watch.lap()));
  }
  measure::Chart chart{.title = task == Task::points_in_tets ? "Points in tets, one thread, 2 % movers"
                                                             : "Border edges, one thread, 2 % movers",
                       .x_label = "tets",
                       .y_label = "ms a frame",
                       .logarithmic = true};
  for (auto& [name, line] : lines) chart.series.push_back(std::move(line));
  // Ours first: its colour is the same in every chart.
  std::ranges::stable_partition(chart.series, [](const measure::Series& s) { return s.name == "Palpate"; });
  section.charts.push_back(std::move(chart));
  section.result_hash = measure::hash_text(hash);
  section.why = fmt::format(
      "With the same number of threads, the other libraries take {:.3g} to {:.3g} times as long as Palpate; "
      "the closest is {}",
      summary.least_lead, summary.most_lead, summary.closest);
  return section;
}

Section peers_section(const std::vector<Absentee>& absent) {
  Section section{
      .id = "peers",
      .title = "Peers: the libraries",
      .ours = "Of each library, the function that is nearest to the question.",
      .why = absent.empty() ? "All can answer both questions" : "Not all can answer both questions",
      .table = {{"library", "what it does here"}, {}}};
  section.table.rows = {
      {"Palpate",
       "Detector as users call it; times of the phases of the task, with canonical order and weights"},
      {"Embree 3",
       "rtcCollide of user geometries; rebuild low, rebuild medium, refit; one scene, or one per body"},
      {"CGAL box_intersection_d",
       "boxes against boxes, four cutoffs, all at once or per body; several threads with "
       "TBB (Parallel_tag)"},
      {"Bullet btDbvt",
       "dynamic trees with updated leaves, tree against tree or primitive by primitive; no threads"},
      {"VTK locator",
       "points: FindCell of vtkStaticCellLocator or vtkCellTreeLocator, one tet per point and body; "
       "edges: FindCellsWithinBounds; rebuilt in each frame; threads share the calls"},
      {"IPC Toolkit", "edge-face candidates of its broad phases, from Python"},
      {"PBAT", "TetrahedralAabbHierarchy.primitives_containing_points, one per body, from Python"}};
  for (const Absentee& absentee : absent)
    section.table.rows.push_back({absentee.name, "skipped: " + absentee.reason});
  return section;
}

}  // namespace palpate::bench
