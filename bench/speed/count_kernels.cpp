// Runs one hot kernel on frames of the stack of membranes, in one thread and with AVX2, so that callgrind
// counts its instructions and nothing else; prints how many units of work they were for.
//
// Usage: palpate-bench-kernels CELLS KERNEL FRAMES   (CELLS: along a side of the membranes; called by
// instructions_part.cpp, with --instr-atstart=no and --collect-atstart=no)
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <hwy/targets.h>
#include <iostream>
#include <span>
#include <string>
#include <valgrind/callgrind.h>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/simulation.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_table.hpp"
#include "contact/crossing_query.hpp"
#include "contact/crossings.hpp"
#include "contact/depth.hpp"
#include "contact/point_query.hpp"
#include "fem/lumping.hpp"
#include "measure/query_scenes.hpp"
#include "our_dynamics.hpp"
#include "our_query.hpp"
#include "scene/generators.hpp"
#include "speed/kernels.hpp"

namespace palpate::bench {
namespace {

/// What is asked for.
struct CountTask {
  std::string_view kernel;
  int cells = 0;
  std::uint32_t frames = 0;
};

/// Frames before those that count: memory grows; and coherence learns.
constexpr std::uint32_t short_warm_up = 2;
constexpr std::uint32_t long_warm_up = 6;

/// Counts a piece of work.
template <class Work>
void count(Work&& work) {
  CALLGRIND_TOGGLE_COLLECT;
  work();
  CALLGRIND_TOGGLE_COLLECT;
}

/// Goes through frames; `use(positions, counts)` returns the units of one.
template <class Use>
std::size_t over_frames(const measure::QueryScene& scene, std::uint32_t warm_up, std::uint32_t frames,
                        Use&& use) {
  std::size_t units = 0;
  std::vector<Vec3> positions;
  for (std::uint32_t f = 0; f < warm_up + frames; ++f) {
    scene.place(f, positions);
    if (f == warm_up) CALLGRIND_START_INSTRUMENTATION;
    const std::size_t of_frame = use(std::span<const Vec3>(positions), f >= warm_up);
    if (f >= warm_up) units += of_frame;
  }
  return units;
}

std::size_t query(const CountTask& task, bool coherent) {
  const measure::QueryScene scene = measure::stacking_scene(task.cells);
  const Setting setting(scene);
  OurQuery ours(setting, 1, coherent);
  return over_frames(scene, coherent ? long_warm_up : short_warm_up, task.frames,
                     [&](std::span<const Vec3> positions, bool counts) {
                       if (!counts) {
                         ours.find(positions);
                       } else {
                         count([&] { ours.find(positions); });
                       }
                       return scene.bodies.tets().size();
                     });
}

enum class Phase { crossings, depth };

/// What Detector does after the query, of which a phase counts.
std::size_t after_query(const CountTask& task, Phase phase) {
  const measure::QueryScene scene = measure::stacking_scene(task.cells);
  const Bodies& bodies = scene.bodies;
  palpate::Frame frame(bodies, {}, scene.immovable(), 1);
  const auto points = make_point_query(bodies, {});
  const auto edges = make_crossing_query(bodies, {});
  ContactTable contacts;
  BorderEdges border_edges(bodies);
  Crossings crossings;
  DepthEstimate depth(bodies);
  return over_frames(scene, short_warm_up, task.frames, [&](std::span<const Vec3> positions, bool counts) {
    const parallel::Threads& threads = frame.threads();
    frame.place(positions, points->clusters());
    points->update(frame, true);
    points->find(frame, {});
    contacts.assign(threads, bodies, positions, points->found());
    border_edges.find(threads, bodies, positions, contacts);
    const BorderEdgeView border{contacts.contacts(), border_edges.edges()};
    const auto counted = [&](Phase which, const auto& work) {
      if (!counts || which != phase) {
        work();
      } else {
        count(work);
      }
    };
    counted(Phase::crossings, [&] {
      edges->find(frame, border, {});
      crossings.set(threads, bodies, positions, border, edges->found());
    });
    counted(Phase::depth,
            [&] { depth.compute(threads, bodies, positions, contacts, border_edges, crossings); });
    return phase == Phase::crossings ? border_edges.edges().size() : contacts.contacts().size();
  });
}

std::size_t detection(const CountTask& task) {
  const measure::QueryScene scene = measure::stacking_scene(task.cells);
  Detector detector(scene.bodies, {}, scene.immovable(), 1);
  return over_frames(scene, long_warm_up, task.frames, [&](std::span<const Vec3> positions, bool counts) {
    if (!counts) {
      detector.detect(positions);
    } else {
      count([&] { detector.detect(positions); });
    }
    return scene.bodies.tets().size();
  });
}

/// The stack falls; its membranes touch at the start.
std::size_t steps(const CountTask& task) {
  const Model model = measure::stacking_model(task.cells);
  const std::size_t tets = model.bodies.tets().size();
  Simulation simulation(model, {}, 1);
  for (std::uint32_t s = 0; s < short_warm_up; ++s) simulation.step();
  CALLGRIND_START_INSTRUMENTATION;
  for (std::uint32_t s = 0; s < task.frames; ++s) count([&] { simulation.step(); });
  return tets * task.frames;
}

/// The membranes at rest, deformed.
struct Membranes {
  explicit Membranes(int cells) {
    for (int i = 0; i < 20; ++i)
      bodies.add("membrane " + std::to_string(i), make_box({cells, cells, 1}, {0.2, 0.2, 0.01}));
    const auto rest = bodies.points_rest();
    const std::vector<Material> materials(bodies.bodies().size(), material);
    masses = fem::lumped_masses(bodies, materials);
    free.assign(rest.size(), 1);
  }
  Bodies bodies;
  Material material{2e4, 0.4, 1000.0, 0.0, 0.002};
  std::vector<double> masses;
  std::vector<std::uint8_t> free;
};

std::size_t dynamics(const CountTask& task) {
  const std::string_view kernel = task.kernel;
  const parallel::Threads threads(1);
  Membranes membranes(task.cells);
  const bool neo_hookean = kernel == "element pass, neo-Hookean";
  if (neo_hookean) membranes.material.model = MaterialModel::stable_neo_hookean;
  OurDynamics ours(membranes.bodies, membranes.material, membranes.free, membranes.masses);
  const auto rest = membranes.bodies.points_rest();
  const std::size_t tets = membranes.bodies.tets().size();
  const std::size_t points = rest.size();
  const simd::AlignedVector<simd::Quad> x(ours.matrix.row_count(), {1.0F, 2.0F, 3.0F, 0.0F});
  const simd::AlignedVector<float> r(3 * x.size(), 1.0F);
  simd::AlignedVector<float> y(3 * x.size());
  ours.update(threads, deformed(rest, 0));
  ours.solve(Preconditioner::multigrid, 1e-3, deformed(rest, 0));  // makes preconditioner and hierarchy
  CALLGRIND_START_INSTRUMENTATION;
  std::size_t units = 0;
  for (std::uint32_t f = 1; f <= task.frames; ++f) {
    const std::vector<Vec3> positions = deformed(rest, static_cast<int>(f));
    if (neo_hookean || kernel == "element pass") {
      count([&] { ours.elements.update(threads, positions); });
      units += tets;
    } else if (kernel == "assembly") {
      ours.elements.update(threads, positions);
      count([&] { ours.matrix.assemble(threads, ours.masses); });
      units += tets;
    } else if (kernel == "product with the matrix") {
      count([&] { ours.system.multiply(threads, x, y); });
      units += points;
    } else if (kernel == "conjugate gradients") {
      constexpr int iterations = 25;
      std::fill(ours.solution.begin(), ours.solution.end(), simd::Padded3{});
      const fem::SolveGoal goal{.max_iterations = iterations, .fixed_iterations = iterations};
      count([&] { ours.solver.solve(threads, ours.system, ours.right_side, ours.solution, goal); });
      units += points * iterations;
    } else {
      count([&] { ours.multigrid.apply(threads, ours.system, r, y); });
      units += points;
    }
  }
  return units;
}

std::size_t run(const CountTask& task) {
  if (task.kernel == "point query, full rebuild") return query(task, false);
  if (task.kernel == "point query, coherent") return query(task, true);
  if (task.kernel == "crossings") return after_query(task, Phase::crossings);
  if (task.kernel == "depth") return after_query(task, Phase::depth);
  if (task.kernel == "whole detection") return detection(task);
  if (task.kernel == "step of the falling stack") return steps(task);
  return dynamics(task);
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  using palpate::bench::Kernel;
  const std::string_view kernel = argc == 4 ? argv[2] : "";
  if (std::ranges::find(palpate::bench::kernels, kernel, &Kernel::name) == palpate::bench::kernels.end()) {
    std::cerr << "usage: palpate-bench-kernels CELLS KERNEL FRAMES\n";
    return 2;
  }
  if ((hwy::SupportedTargets() & HWY_AVX2) == 0) {
    std::cerr << "found a processor without AVX2, expected one with it\n";
    return 1;
  }
  const palpate::bench::ForcedTarget avx2(HWY_AVX2);
  const auto frames = static_cast<std::uint32_t>(std::atoi(argv[3]));
  std::cout << palpate::bench::run({kernel, std::atoi(argv[1]), frames}) << '\n';
  return 0;
}
