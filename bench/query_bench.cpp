// Points in tets, frame by frame: the clustered query compared with the query of single tets and with Embree.
// Every competitor gets the positions of each frame, one after the other, and their pairs are compared.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <hwy/targets.h>
#include <memory>
#include <string>
#include <tbb/global_control.h>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "contact/points_in_tets.hpp"
#include "measure/query_scenes.hpp"
#include "our_query.hpp"
#include "peers/embree_peer.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

using measure::QueryScene;

constexpr int query_frames = 41;
/// Tets beyond which only our own query runs, in fewer frames: how its time grows.
constexpr std::size_t most_tets_of_all = 2'000'000;
/// Frames before the first measured one let memory grow, and give the repair sort its last order.
constexpr std::uint32_t query_warm_up = 2;
/// Frames in a row of one competitor, before it is the next one's turn.
constexpr std::uint32_t batch = 6;

/// A method of finding the pairs of a frame.
struct Competitor {
  std::string name;
  std::function<std::span<const PointInTet>(std::span<const Vec3>)> find;
  int threads = 1;
  std::vector<double> seconds{};
};

/// Seconds of processor time that this thread had, so that other work on the machine counts less; with
/// several threads, of wall time.
double now(int threads) {
  if (threads > 1)
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  return processor_time();
}

/// The clustered query, with its grid.
/// \param target    of Highway; 0: the best
/// \param coherent  with lists of near points, made for earlier frames
Competitor clustered(const std::string& name, const Setting& setting, int threads, std::int64_t target = 0,
                     bool coherent = false) {
  const auto query = std::make_shared<OurQuery>(setting, threads, coherent);
  return {name,
          [query, target](std::span<const Vec3> positions) {
            const ForcedTarget forced(target);
            return query->find(positions);
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
            const Box bounds = bounds_of(s.threads, positions, setting.included, s.scratch);
            if (!setting.lattice.domain().contains(bounds.lower))
              throw std::logic_error("positions beyond the lattice");
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
  all.push_back(clustered("clustered", setting, 1));
  all.push_back(clustered("coherent", setting, 1, 0, true));
  if (setting.scene.bodies.tets().size() > most_tets_of_all) return all;
  for (const auto& [name, target] : {std::pair("AVX2", HWY_AVX2), std::pair("SSE4", HWY_SSE4)}) {
    if ((hwy::SupportedTargets() & target) != 0)
      all.push_back(clustered("clustered, " + std::string(name), setting, 1, target));
  }
  all.push_back(clustered("clustered, 2 threads", setting, 2));
  // In wall time, as with 2 threads.
  all.push_back(clustered("clustered, 1 thread", setting, 1));
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
bool run_batch(const QueryScene& scene, Competitor& c, std::uint32_t first, std::uint32_t last,
               std::vector<std::vector<PointInTet>>& expected) {
  std::vector<Vec3> positions;
  for (std::uint32_t frame = first; frame < last; ++frame) {
    scene.place(frame, positions);
    const double start = now(c.threads);
    const std::span<const PointInTet> found = c.find(positions);
    if (frame >= query_warm_up) c.seconds.push_back(now(c.threads) - start);
    std::vector<PointInTet> pairs = sorted(found);
    if (expected.size() <= frame) {
      expected.push_back(std::move(pairs));
    } else if (!equal(pairs, expected[frame])) {
      return false;
    }
  }
  return true;
}

Json measure(const QueryScene& scene, std::uint32_t count) {
  const Setting setting(scene);
  std::vector<Competitor> all = competitors(setting);
  // Embree works in the thread that measures.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<std::vector<PointInTet>> expected;
  for (std::uint32_t first = 0; first < query_warm_up + count; first += batch) {
    const std::uint32_t last = std::min(first + batch, query_warm_up + count);
    for (std::size_t i = 0; i < all.size(); ++i) {
      Competitor& c = all[(i + first / batch) % all.size()];
      if (!run_batch(scene, c, first, last, expected))
        throw Error("benchmark", scene.name, "other pairs by '" + c.name + "'", "those that the others find");
    }
  }
  Json result{{"name", scene.name},
              {"tets", scene.bodies.tets().size()},
              {"points", scene.places.size()},
              {"pairs", expected.back().size()},
              {"cell_size", setting.cell_size},
              {"frames", count},
              {"best_target", hwy::TargetName(hwy::SupportedTargets() & -hwy::SupportedTargets())}};
  for (const Competitor& c : all) {
    result["median_ms"][c.name] = 1e3 * median(c.seconds);
    result["smallest_ms"][c.name] = 1e3 * *std::min_element(c.seconds.begin(), c.seconds.end());
  }
  return result;
}

}  // namespace

Part query_part(const SpeedEffort& effort) {
  const auto stacking = [](int cells) { return [cells] { return measure::stacking_scene(cells); }; };
  struct SceneToAsk {
    const char* name;
    double tets;
    std::function<QueryScene()> make;
  };
  std::vector<SceneToAsk> scenes = {
      {"stacking 10000", 1e4, stacking(10)},        {"stacking 102400", 102400, stacking(32)},
      {"stacking 1000000", 1e6, stacking(100)},     {"pile", 82240, measure::pile_scene},
      {"self-collision", 1e4, measure::self_scene}, {"stacking 9985600", 9985600, stacking(316)}};
  scenes.push_back({"tubes", 42000, measure::tubes_scene});
  if (!effort.raptors.empty()) {
    scenes.push_back({"raptors", 8418 + 19409, [folder = effort.raptors] {
                        return measure::raptors_scene(io::read_mesh(folder / "raptorTetra_8418.vtu").mesh,
                                                      io::read_mesh(folder / "raptorTetra_19409.vtu").mesh);
                      }});
  }
  // Organs: unstructured meshes, where little touches at the start.
  for (const auto& [name, tets] : {std::pair("eye", 10160.0), std::pair("skull", 24071.0)}) {
    const std::filesystem::path file = effort.scenes / (std::string(name) + ".json");
    if (!std::filesystem::exists(file)) continue;
    scenes.push_back({name, tets, [file, name] {
                        const auto read = [](const std::filesystem::path& path) {
                          return io::read_mesh(path).mesh;
                        };
                        return measure::shipped_scene(name, load_model(read_scene(file), read).bodies);
                      }});
  }
  Part part{"query", {}, query_rows};
  for (const auto& scene : scenes) {
    const int frames = effort.frames_or(scene.tets > most_tets_of_all ? 7 : query_frames);
    part.cases.push_back({scene.name, scene.tets, [make = scene.make, frames] {
                            return measure(make(), static_cast<std::uint32_t>(frames));
                          }});
  }
  return part;
}

}  // namespace palpate::bench
