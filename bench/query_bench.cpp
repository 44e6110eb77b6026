// Points in tets, frame after frame: the clustered query beside the query of single tets and Embree. Each
// frame's positions go to every competitor in turn, and the pairs that each finds are compared; a wrong
// result ends the program with 1.
//
// Usage: palpate_bench_query JSON [SCENE...]   (SCENE: the name of a scene; default: all)
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <hwy/targets.h>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <tbb/global_control.h>

#include "contact/cluster_query.hpp"
#include "contact/points_in_tets.hpp"
#include "grid/cell_size.hpp"
#include "handling_bench.hpp"
#include "io/machine.hpp"
#include "measure/query_scenes.hpp"
#include "peers/embree_peer.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

using measure::QueryScene;

constexpr std::uint32_t frames = 41;
/// Tets beyond which only our own query runs, in fewer frames: how its time grows.
constexpr std::size_t most_tets_of_all = 2'000'000;
/// Frames before the first measured one let memory grow, and give the repair sort its last order.
constexpr std::uint32_t warm_up = 2;
/// Frames in a row of one competitor, before it is the next one's turn.
constexpr std::uint32_t turn = 6;

/// One way to find the pairs of a frame.
struct Competitor {
  std::string name;
  std::function<std::span<const PointInTet>(std::span<const Vec3>)> find;
  int threads = 1;
  std::vector<double> seconds{};
};

/// Seconds of processor time that this thread had, so that other work on the machine counts less; with
/// several threads, of time that passed.
double now(int threads) {
  if (threads > 1)
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  return processor_time();
}

/// What a scene is made of, for our own competitors.
struct Setting {
  explicit Setting(const QueryScene& s)
      : scene(s),
        immovable(s.immovable()),
        takes_part(s.places.size(), 1),
        course{s, immovable, Task::points_in_tets} {
    marks.resize(s.places.size());
    for (std::size_t p = 0; p < marks.size(); ++p) marks[p] = at(immovable, s.bodies.body_of_point()[p]);
    parallel::Threads one(1);
    cell_size = choose_cell_size(one, s.bodies, s.places, takes_part, CellSizeRule::automatic).cell_size;
    Box bounds;
    for (const Vec3& p : s.places) bounds.extend(p);
    const Vec3 pad{2 * cell_size, 2 * cell_size, 2 * cell_size};
    lattice = Lattice({bounds.lower - pad, bounds.upper + pad}, cell_size);
  }
  [[nodiscard]] PairFilter may_touch() const { return {immovable, scene.self_collision}; }

  const QueryScene& scene;
  std::vector<std::uint8_t> immovable;
  std::vector<std::uint8_t> takes_part;
  std::vector<std::uint8_t> marks;
  Course course;
  double cell_size = 0.0;
  Lattice lattice;
};

/// The clustered query, with its grid.
/// \param coherent  with lists of near points, made for earlier frames
Competitor clustered(const std::string& name, const Setting& setting, int threads, std::int64_t targets,
                     bool coherent = false) {
  struct State {
    explicit State(const Setting& s, int n)
        : threads(n), query(s.scene.bodies), fixed(s.takes_part, s.marks) {}
    parallel::Threads threads;
    CompactGrid grid;
    ClusterQuery query;
    FixedPositions fixed;
    bool is_new = true;
  };
  const auto state = std::make_shared<State>(setting, threads);
  return {name,
          [state, targets, coherent, &setting](std::span<const Vec3> positions) {
            if (targets != 0) {
              hwy::SetSupportedTargetsForTest(targets);
              hwy::GetChosenTarget().Update(targets);
            }
            State& s = *state;
            const std::optional<Box> bounds = s.fixed.place(s.threads, setting.lattice, positions);
            if (!setting.lattice.domain().contains(bounds.value().lower)) throw std::runtime_error("domain");
            if (!coherent || s.query.begin_frame(s.threads, setting.scene.bodies, s.fixed, s.is_new)) {
              s.grid.build_points(s.threads, setting.lattice, s.fixed);
              s.fixed.put_in_order(s.threads, s.grid.entries());
            }
            s.is_new = false;
            s.query.find(s.threads, setting.scene.bodies, positions, setting.may_touch(), s.grid, s.fixed);
            if (targets != 0) {
              hwy::SetSupportedTargetsForTest(0);
              hwy::GetChosenTarget().Update(hwy::SupportedTargets());
            }
            return s.query.found();
          },
          threads};
}

/// The query of single tets, with its grid: what the clustered one replaced.
Competitor single_tets(const Setting& setting) {
  struct State {
    parallel::Threads threads{1};
    CompactGrid grid;
    PointsInTets query;
    std::vector<Box> scratch;
  };
  const auto state = std::make_shared<State>();
  return {"single tets", [state, &setting](std::span<const Vec3> positions) {
            State& s = *state;
            const Box bounds = bounds_of(s.threads, positions, setting.takes_part, s.scratch);
            if (!setting.lattice.domain().contains(bounds.lower)) throw std::runtime_error("domain");
            s.grid.build_points(s.threads, setting.lattice, positions.size(), [&](Index p) {
              return std::optional(setting.lattice.cell_of(at(positions, p)));
            });
            s.query.find(s.threads, setting.scene.bodies, positions, setting.may_touch(), setting.lattice,
                         s.grid, CellSlots());
            return s.query.found();
          }};
}

std::vector<Competitor> competitors(const Setting& setting) {
  std::vector<Competitor> all;
  all.push_back(clustered("clustered", setting, 1, 0));
  all.push_back(clustered("coherent", setting, 1, 0, true));
  if (setting.scene.bodies.tets().size() > most_tets_of_all) return all;
  all.push_back(clustered("clustered, AVX2", setting, 1, HWY_AVX2));
  all.push_back(clustered("clustered, SSE4", setting, 1, HWY_SSE4));
  all.push_back(clustered("clustered, 2 threads", setting, 2, 0));
  // In time that passed, as with 2 threads.
  all.push_back(clustered("clustered, 1 thread", setting, 1, 0));
  all.back().threads = 2;
  all.push_back(single_tets(setting));
  struct Embree {
    std::unique_ptr<Peer> peer;
    std::vector<Pair> pairs;
    std::vector<PointInTet> found;
  };
  for (const EmbreeMode& mode : every_embree_mode()) {
    const auto embree = std::make_shared<Embree>();
    embree->peer = make_embree_peer(setting.course, mode);
    all.push_back({"Embree: " + mode.name(), [embree](std::span<const Vec3> positions) {
                     static_cast<void>(embree->peer->find({positions, {}}, embree->pairs));
                     embree->found.clear();
                     for (const Pair& pair : embree->pairs)
                       embree->found.push_back({pair.first, pair.second});
                     return std::span<const PointInTet>(embree->found);
                   }});
  }
  return all;
}

std::vector<PointInTet> sorted(std::span<const PointInTet> pairs) {
  std::vector<PointInTet> result(pairs.begin(), pairs.end());
  std::sort(result.begin(), result.end(), [](const PointInTet& a, const PointInTet& b) {
    return a.point != b.point ? a.point < b.point : a.tet < b.tet;
  });
  return result;
}

bool equal(const std::vector<PointInTet>& a, const std::vector<PointInTet>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(PointInTet)) == 0;
}

/// Gives frames [first, last) to a competitor; returns whether it finds what the first one found.
bool take_turn(const QueryScene& scene, Competitor& c, std::uint32_t first, std::uint32_t last,
               std::vector<std::vector<PointInTet>>& expected) {
  std::vector<Vec3> positions;
  for (std::uint32_t frame = first; frame < last; ++frame) {
    scene.place(frame, positions);
    const double start = now(c.threads);
    const std::span<const PointInTet> found = c.find(positions);
    if (frame >= warm_up) c.seconds.push_back(now(c.threads) - start);
    std::vector<PointInTet> pairs = sorted(found);
    if (expected.size() <= frame) {
      expected.push_back(std::move(pairs));
    } else if (!equal(pairs, expected[frame])) {
      return false;
    }
  }
  return true;
}

nlohmann::json run(const QueryScene& scene) {
  const Setting setting(scene);
  std::vector<Competitor> all = competitors(setting);
  const bool is_huge = scene.bodies.tets().size() > most_tets_of_all;
  const std::uint32_t count = is_huge ? 7 : frames;
  // Embree works in the thread that measures.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<std::vector<PointInTet>> expected;
  for (std::uint32_t first = 0; first < warm_up + count; first += turn) {
    const std::uint32_t last = std::min(first + turn, warm_up + count);
    for (std::size_t i = 0; i < all.size(); ++i) {
      Competitor& c = all[(i + first / turn) % all.size()];
      if (!take_turn(scene, c, first, last, expected))
        throw std::runtime_error(scene.name + ": " + c.name + " finds other pairs");
    }
  }
  nlohmann::json result{{"scene", scene.name},
                        {"tets", scene.bodies.tets().size()},
                        {"points", scene.places.size()},
                        {"pairs", expected.back().size()},
                        {"cell_size", setting.cell_size},
                        {"frames", count}};
  if (scene.name == "stacking 10000") {
    result["handling"] = measure_handling(scene, count);
  }
  for (const Competitor& c : all) {
    result["median_ms"][c.name] = 1e3 * median(c.seconds);
    result["smallest_ms"][c.name] = 1e3 * *std::min_element(c.seconds.begin(), c.seconds.end());
  }
  return result;
}

std::vector<std::function<QueryScene()>> scenes() {
  return {[] { return measure::stacking_scene(10); },
          [] { return measure::stacking_scene(32); },
          [] { return measure::stacking_scene(100); },
          measure::pile_scene,
          measure::self_scene,
          [] { return measure::stacking_scene(316); }};
}

int measure(const std::string& file, const std::vector<std::string>& wanted) {
  const io::Machine machine = io::describe_machine();
  nlohmann::json report{{"cpu", machine.cpu},
                        {"cores", machine.cores},
                        {"compiler", machine.compiler + ", " + machine.build_type},
                        {"commit", machine.commit}};
  for (const auto& make : scenes()) {
    const QueryScene scene = make();
    const auto named = [&](const std::string& name) { return scene.name == name; };
    if (!wanted.empty() && std::none_of(wanted.begin(), wanted.end(), named)) continue;
    report["scenes"].push_back(run(scene));
    std::array<double, 1> load{};
    getloadavg(load.data(), 1);
    report["load"].push_back(load[0]);
    std::cerr << scene.name << ": done\n";
    std::ofstream(file) << report.dump(1) << '\n';
  }
  return 0;
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: palpate_bench_query JSON [SCENE...]\n";
    return 2;
  }
  try {
    return palpate::bench::measure(argv[1], {argv + 2, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << "palpate_bench_query: " << error.what() << '\n';
    return 1;
  }
}
