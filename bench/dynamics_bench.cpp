// A step's linear system and its solution, compared with careful code that uses Eigen. One thread.
//
// Frames are distinct deformations of a scene; in each both are measured, one after the other. Of Eigen's
// preconditioners the better is taken, with the loosest tolerance that leads to the error asked for; ours
// gets that error as its goal. Solutions are compared with a direct one (of large meshes: with conjugate
// gradients to 1e-10).
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "eigen_dynamics.hpp"
#include "fem/lumping.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"
#include "our_dynamics.hpp"
#include "scene/generators.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr double goal = 1e-3;
constexpr int dynamics_frames = 41;
const parallel::Threads one_thread(1);

struct Body {
  std::string name;
  Bodies bodies;
  Material material;
  double held_fraction = 0.0;  ///< of the height, from below: fixed
  int frames = 0;
  bool direct = true;
};

double error_of(const OurDynamics& ours, const EigenDynamics& eigen, const Eigen::VectorXd& exact) {
  Eigen::VectorXd x(exact.size());
  for (std::size_t p = 0; p < ours.free.size(); ++p) {
    const auto& s = ours.solution[p];
    if (eigen.place()[p] >= 0) x.segment<3>(3 * eigen.place()[p]) << s.x, s.y, s.z;
  }
  return (x - exact).norm() / exact.norm();
}

Eigen::VectorXd exact_solution(const EigenDynamics& eigen, bool direct) {
  if (direct) {
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(Eigen::SparseMatrix<double>(eigen.matrix()))
        .solve(eigen.right_side());
  }
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> cg;
  cg.setTolerance(1e-10);
  cg.compute(eigen.matrix());
  return cg.solve(eigen.right_side());
}

using Diagonal =
    Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper>;
using Incomplete = Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>,
                                            Eigen::Lower | Eigen::Upper, Eigen::IncompleteCholesky<double>>;

struct EigenRun {
  double tolerance = 0.0;
  double time = 0.0;
  double error = 0.0;
  long iterations = 0;
};

template <class Solver>
EigenRun run_eigen(const EigenDynamics& eigen, const Eigen::VectorXd& exact, double tolerance) {
  EigenRun run{.tolerance = tolerance};
  Eigen::VectorXd x;
  run.time = milliseconds([&] {
    Solver solver;
    solver.setTolerance(tolerance);
    solver.setMaxIterations(100000);
    solver.compute(eigen.matrix());
    x = solver.solve(eigen.right_side());
    run.iterations = solver.iterations();
  });
  run.error = (x - exact).norm() / exact.norm();
  return run;
}

/// Solves with the loosest tolerance that reaches the goal.
template <class Solver>
EigenRun calibrated(const EigenDynamics& eigen, const Eigen::VectorXd& exact) {
  EigenRun run;
  for (double tolerance = 1e-1; tolerance > 1e-9; tolerance *= 0.5) {
    run = run_eigen<Solver>(eigen, exact, tolerance);
    if (run.error <= goal) break;
  }
  return run;
}

/// Bandwidth of reading this number of bytes repeatedly, GB/s: one value of each cache line, since lines take
/// the time.
double read_bandwidth(std::size_t bytes) {
  const std::vector<std::uint64_t> data(bytes / 8, 3);
  std::array<std::uint64_t, 4> sums{};
  std::vector<double> times;
  for (int i = 0; i < 21; ++i) {
    times.push_back(milliseconds([&] {
      for (std::size_t k = 0; k + 32 <= data.size(); k += 32) {
        for (std::size_t j = 0; j < 4; ++j) sums[j] += data[k + 8 * j];
      }
    }));
  }
  if (sums[0] + sums[1] + sums[2] + sums[3] == 1) std::puts("");  // keeps the loops
  return static_cast<double>(bytes) / median(times) * 1e-6;
}

Json measure(const Body& c) {
  const auto rest = c.bodies.points_rest();
  const std::vector<Material> materials(static_cast<std::size_t>(c.bodies.body_count()), c.material);
  const auto masses = fem::lumped_masses(c.bodies, materials);
  std::vector<std::uint8_t> free(rest.size(), 1);
  const auto [low, high] = std::ranges::minmax(rest, {}, &Vec3::z);
  for (std::size_t p = 0; p < rest.size(); ++p) {
    const bool held = c.held_fraction > 0.0 && rest[p].z <= low.z + c.held_fraction * (high.z - low.z);
    if (held || masses[p] == 0.0) free[p] = 0;
  }
  EigenDynamics eigen(c.bodies, c.material, free, masses, OurDynamics::time_step);
  OurDynamics ours(c.bodies, c.material, free, masses);
  std::vector<double> eigen_update;
  std::vector<double> eigen_solve;
  std::vector<double> our_update;
  std::array<std::vector<double>, 3> our_solve;
  std::array<double, 3> our_error{};
  std::array<int, 3> our_iterations{};
  std::vector<double> product;
  const simd::AlignedVector<simd::Quad> product_x(ours.matrix.row_count(), {1.0F, 2.0F, 3.0F, 0.0F});
  simd::AlignedVector<float> product_y(3 * product_x.size());
  double eigen_error = 0.0;
  bool incomplete = false;
  double tolerance = 0.0;
  long iterations = 0;
  for (int frame = -1; frame < c.frames; ++frame) {  // the first is to warm up and to calibrate
    const auto positions = deformed(rest, frame);
    // Each runs with the caches of its own last frame and not of the other's, as in a simulation.
    const auto before = deformed(rest, frame - 1);
    eigen.update(before, OurDynamics::gravity);
    const double eigen_time = milliseconds([&] { eigen.update(positions, OurDynamics::gravity); });
    ours.update(one_thread, before);
    const double our_time = milliseconds([&] { ours.update(one_thread, positions); });
    const Eigen::VectorXd exact = exact_solution(eigen, c.direct);
    if (frame < 0) {
      const EigenRun diagonal = calibrated<Diagonal>(eigen, exact);
      const EigenRun cholesky = calibrated<Incomplete>(eigen, exact);
      incomplete = cholesky.time < diagonal.time && cholesky.error <= goal;
      tolerance = incomplete ? cholesky.tolerance : diagonal.tolerance;
      for (int k = 0; k < 3; ++k) ours.solve(static_cast<Preconditioner>(k), goal, positions);
      continue;
    }
    eigen_update.push_back(eigen_time);
    our_update.push_back(our_time);
    const EigenRun run = incomplete ? run_eigen<Incomplete>(eigen, exact, tolerance)
                                    : run_eigen<Diagonal>(eigen, exact, tolerance);
    eigen_solve.push_back(run.time);
    eigen_error = std::max(eigen_error, run.error);
    iterations = run.iterations;
    for (std::size_t k = 0; k < 3; ++k) {
      our_solve[k].push_back(milliseconds([&] {
        our_iterations[k] = ours.solve(static_cast<Preconditioner>(k), goal, positions).iterations;
      }));
      our_error[k] = std::max(our_error[k], error_of(ours, eigen, exact));
    }
    const auto multiply = [&] { ours.system.multiply(one_thread, product_x, product_y); };
    multiply();
    for (int i = 0; i < 3; ++i) product.push_back(milliseconds(multiply));
  }
  // Each 3x3 block stores nine values and one column index, four bytes each.
  const std::size_t bytes = ours.matrix.value_bytes() / 9 * 10;
  Json json{{"name", c.name},
            {"points", rest.size()},
            {"tets", c.bodies.tets().size()},
            {"frames", c.frames},
            {"goal", goal},
            {"eigen",
             {{"update_ms", median(eigen_update)},
              {"solve_ms", median(eigen_solve)},
              {"preconditioner", incomplete ? "incomplete Cholesky" : "diagonal"},
              {"tolerance", tolerance},
              {"iterations", iterations},
              {"largest_error", eigen_error}}},
            {"update_ms", median(our_update)},
            {"product",
             {{"ms", median(product)},
              {"bytes", bytes},
              {"GB_per_s", static_cast<double>(bytes) / median(product) * 1e-6},
              {"read_GB_per_s", read_bandwidth(bytes)}}}};
  for (std::size_t k = 0; k < 3; ++k) {
    json["solve"][std::string(preconditioner_names[k])] = {
        {"ms", median(our_solve[k])}, {"iterations", our_iterations[k]}, {"largest_error", our_error[k]}};
    if (!(our_error[k] <= 2.0 * goal)) {
      throw Error("benchmark", c.name + ", " + std::string(preconditioner_names[k]),
                  "an error of " + number_text(our_error[k]), "at most twice the goal, " + number_text(goal));
    }
  }
  return json;
}

Body stacking() {
  Body body{.name = "stacking", .bodies = {}, .material = {2e4, 0.4, 1000.0, 0.0, 0.002}};
  for (int i = 0; i < 20; ++i)
    body.bodies.add("membrane " + std::to_string(i), make_box({10, 10, 1}, {0.2, 0.2, 0.01}));
  return body;
}

Body head(const std::filesystem::path& folder) {
  Body body{.name = "skull", .bodies = {}, .material = {2e5, 0.4, 1000.0, 0.0, 0.002}, .held_fraction = 0.05};
  for (const char* part : {"skull", "lower", "upper", "soft"}) {
    TetMesh mesh = io::read_mesh(folder / ("hq_" + std::string(part) + ".mesh")).mesh;
    for (Vec3& p : mesh.points) p = 1e-3 * p;  // the files are in mm
    body.bodies.add(part, mesh);
  }
  return body;
}

Body block() {
  Body body{.name = "block",
            .bodies = {},
            .material = {2e4, 0.4, 1000.0, 0.0, 0.002},
            .held_fraction = 0.01,
            .direct = false};
  body.bodies.add("block", make_box({58, 58, 58}, {0.5, 0.5, 0.5}));
  return body;
}

}  // namespace

Part dynamics_part(const SpeedEffort& effort) {
  const auto with_frames = [&](auto make, int usual) {
    return [make, frames = effort.frames_or(usual)] {
      Body body = make();
      body.frames = frames;
      return measure(body);
    };
  };
  Part part{"dynamics", {{"stacking", 1e4, with_frames(stacking, dynamics_frames)}}, dynamics_rows};
  if (!effort.skull.empty())
    part.cases.push_back(
        {"skull", 23313, with_frames([folder = effort.skull] { return head(folder); }, dynamics_frames)});
  part.cases.push_back({"block", 975560, with_frames(block, 3)});
  return part;
}

}  // namespace palpate::bench
