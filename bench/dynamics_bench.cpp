// A step's linear system and its solution, beside what a careful user of Eigen writes. One thread.
//
//   palpate_bench_dynamics JSON [SKULL_FOLDER [CASE]]
//
// Frames are distinct deformations of a scene; in each both are measured in turn. Of Eigen's preconditioners
// the better is taken, with the loosest tolerance that leads to the error asked for; ours gets that error as
// its goal. Solutions are compared with a direct one (of large meshes: with conjugate gradients to 1e-10);
// one that is wrong fails the run.
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "eigen_dynamics.hpp"
#include "fem/conjugate_gradients.hpp"
#include "fem/lumping.hpp"
#include "geometry/vector.hpp"
#include "io/mesh_reader.hpp"
#include "scene/generators.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr double time_step = 0.01;
constexpr double goal = 1e-3;
constexpr Vec3 gravity{0.0, 0.0, -9.81};
const parallel::Threads one_thread(1);

struct Case {
  std::string name;
  Bodies bodies;
  Material material;
  double held_share = 0.0;  ///< of the height, from below: fixed
  int frames = 41;
  bool direct = true;
};

/// A bent and twisted shape, another for each frame.
std::vector<Vec3> deformed(std::span<const Vec3> rest, int frame) {
  Vec3 lower = rest[0];
  Vec3 upper = rest[0];
  for (const Vec3& p : rest) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  const double size = std::max({upper.x - lower.x, upper.y - lower.y, upper.z - lower.z});
  std::vector<Vec3> positions;
  for (const Vec3& p : rest) {
    const Vec3 u = (6.28 / size) * (p - lower);
    const double t = 0.15 * frame;
    const double a = 0.004 * size;
    positions.push_back(p + a * Vec3{std::sin(u.y + 0.7 * u.z + t), std::sin(u.z + t) * std::cos(0.6 * u.x),
                                     0.6 * std::cos(u.x + 1.3 * u.y - t)});
  }
  return positions;
}

/// Ours, as a step runs it.
struct Ours {
  Ours(const Bodies& bodies, const Material& material, std::vector<std::uint8_t> free_points,
       std::span<const double> point_masses)
      : free(std::move(free_points)),
        masses(point_masses.begin(), point_masses.end()),
        elements(bodies, std::vector<Material>(static_cast<std::size_t>(bodies.body_count()), material),
                 std::vector<std::uint8_t>(static_cast<std::size_t>(bodies.body_count()), 0)),
        matrix(elements, free),
        system(matrix, couplings, free),
        coarse(bodies, free),
        factor(matrix),
        right_side(free.size()),
        solution(free.size()) {
    const double share = time_step * (material.stiffness_damping + time_step);
    elements.set_factors(std::vector<double>(static_cast<std::size_t>(elements.size()), share));
    couplings.set({}, time_step, free);
  }
  void update(std::span<const Vec3> positions) {
    elements.update(one_thread, positions);
    matrix.assemble(one_thread, masses);
    const auto elastic = elements.point_forces();
    for (std::size_t p = 0; p < free.size(); ++p) {
      if (free[p] == 0) continue;
      const simd::Padded3& f = elastic[p];
      const Vec3 force = masses[p] * gravity + Vec3{f.x, f.y, f.z};
      right_side[p] = {time_step * force.x, time_step * force.y, time_step * force.z, 0.0};
    }
  }
  fem::SolveReport solve(Preconditioner preconditioner, std::span<const Vec3> positions) {
    std::fill(solution.begin(), solution.end(), simd::Padded3{});
    system.update_preconditioner(one_thread);
    const fem::SolveReport report = solver.solve(one_thread, system, right_side, solution,
                                                 {.tolerance = goal,
                                                  .max_iterations = 100000,
                                                  .of_solution = true,
                                                  .preconditioner = preconditioner,
                                                  .stage = stage},
                                                 &coarse, positions, &factor);
    if (preconditioner == Preconditioner::automatic) stage = report.stage;
    return report;
  }
  std::vector<std::uint8_t> free;
  std::vector<double> masses;
  fem::Elements elements;
  fem::BlockMatrix matrix;
  fem::CouplingSystem couplings;
  fem::LinearSystem system;
  fem::CoarseSpace coarse;
  fem::RestFactor factor;
  fem::Stage stage = fem::Stage::start;
  fem::ConjugateGradients solver;
  std::vector<simd::Padded3> right_side;
  std::vector<simd::Padded3> solution;
};

double error_of(const Ours& ours, const EigenDynamics& eigen, const Eigen::VectorXd& exact) {
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

/// With the loosest tolerance that leads to the goal.
template <class Solver>
EigenRun calibrated(const EigenDynamics& eigen, const Eigen::VectorXd& exact) {
  EigenRun run;
  for (double tolerance = 1e-1; tolerance > 1e-9; tolerance *= 0.5) {
    run = run_eigen<Solver>(eigen, exact, tolerance);
    if (run.error <= goal) break;
  }
  return run;
}

/// Bandwidth of reading as many bytes again and again, GB/s: a value of each cache line, as the lines are
/// what takes the time.
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

nlohmann::json measure(Case& c, bool& wrong) {
  const auto rest = c.bodies.points_rest();
  const std::vector<Material> materials(static_cast<std::size_t>(c.bodies.body_count()), c.material);
  const auto masses = fem::lumped_masses(c.bodies, materials);
  std::vector<std::uint8_t> free(rest.size(), 1);
  const auto [low, high] = std::ranges::minmax(rest, {}, &Vec3::z);
  for (std::size_t p = 0; p < rest.size(); ++p) {
    const bool held = c.held_share > 0.0 && rest[p].z <= low.z + c.held_share * (high.z - low.z);
    if (held || masses[p] == 0.0) free[p] = 0;
  }
  EigenDynamics eigen(c.bodies, c.material, free, masses, time_step);
  Ours ours(c.bodies, c.material, free, masses);
  std::vector<double> eigen_update;
  std::vector<double> eigen_solve;
  std::vector<double> our_update;
  std::array<std::vector<double>, 4> our_solve;
  std::array<double, 4> our_error{};
  std::array<int, 4> our_iterations{};
  std::vector<double> product;
  const simd::AlignedVector<simd::Quad> product_x(ours.matrix.row_count(), {1.0F, 2.0F, 3.0F, 0.0F});
  simd::AlignedVector<float> product_y(3 * product_x.size());
  double eigen_error = 0.0;
  bool incomplete = false;
  double tolerance = 0.0;
  long iterations = 0;
  for (int frame = -1; frame < c.frames; ++frame) {  // the first is to warm up and to calibrate
    const auto positions = deformed(rest, frame);
    // Each runs in caches as its own last frame has left them, not as the other has: as in a simulation.
    const auto before = deformed(rest, frame - 1);
    eigen.update(before, gravity);
    const double eigen_time = milliseconds([&] { eigen.update(positions, gravity); });
    ours.update(before);
    const double our_time = milliseconds([&] { ours.update(positions); });
    const Eigen::VectorXd exact = exact_solution(eigen, c.direct);
    if (frame < 0) {
      const EigenRun diagonal = calibrated<Diagonal>(eigen, exact);
      const EigenRun cholesky = calibrated<Incomplete>(eigen, exact);
      incomplete = cholesky.time < diagonal.time && cholesky.error <= goal;
      tolerance = incomplete ? cholesky.tolerance : diagonal.tolerance;
      for (int k = 0; k < 4; ++k) ours.solve(static_cast<Preconditioner>(k), positions);
      continue;
    }
    eigen_update.push_back(eigen_time);
    our_update.push_back(our_time);
    const EigenRun run = incomplete ? run_eigen<Incomplete>(eigen, exact, tolerance)
                                    : run_eigen<Diagonal>(eigen, exact, tolerance);
    eigen_solve.push_back(run.time);
    eigen_error = std::max(eigen_error, run.error);
    iterations = run.iterations;
    for (std::size_t k = 0; k < 4; ++k) {
      our_solve[k].push_back(milliseconds(
          [&] { our_iterations[k] = ours.solve(static_cast<Preconditioner>(k), positions).iterations; }));
      our_error[k] = std::max(our_error[k], error_of(ours, eigen, exact));
    }
    const auto multiply = [&] { ours.system.multiply(one_thread, product_x, product_y); };
    multiply();
    for (int i = 0; i < 3; ++i) product.push_back(milliseconds(multiply));
  }
  // Values and columns, of four bytes each: nine and one a block.
  const std::size_t bytes = ours.matrix.value_bytes() / 9 * 10;
  nlohmann::json json{{"name", c.name},
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
  for (std::size_t k = 0; k < 4; ++k) {
    json["solve"][std::string(preconditioner_names[k])] = {
        {"ms", median(our_solve[k])}, {"iterations", our_iterations[k]}, {"largest_error", our_error[k]}};
    if (!(our_error[k] <= 2.0 * goal)) wrong = true;
  }
  return json;
}

std::vector<Case> cases(const std::string& skull) {
  std::vector<Case> all;
  Case stacking{.name = "stacking", .bodies = {}, .material = {2e4, 0.4, 1000.0, 0.0, 0.002}};
  for (int i = 0; i < 20; ++i)
    stacking.bodies.add("membrane " + std::to_string(i), make_box({10, 10, 1}, {0.2, 0.2, 0.01}));
  all.push_back(std::move(stacking));
  if (std::filesystem::exists(skull)) {
    Case head{.name = "skull", .bodies = {}, .material = {2e5, 0.4, 1000.0, 0.0, 0.002}, .held_share = 0.05};
    for (const char* part : {"skull", "lower", "upper", "soft"}) {
      TetMesh mesh = io::read_mesh(skull + "/hq_" + part + ".mesh").mesh;
      for (Vec3& p : mesh.points) p = 1e-3 * p;  // the files are in mm
      head.bodies.add(part, mesh);
    }
    all.push_back(std::move(head));
  }
  Case block{.name = "block",
             .bodies = {},
             .material = {2e4, 0.4, 1000.0, 0.0, 0.002},
             .held_share = 0.01,
             .frames = 3,
             .direct = false};
  block.bodies.add("block", make_box({58, 58, 58}, {0.5, 0.5, 0.5}));
  all.push_back(std::move(block));
  return all;
}

int run(int argc, char** argv) {
  nlohmann::json json{{"context", machine_context()}, {"references", machine_references()}};
  bool wrong = false;
  for (Case& c : cases(argc > 2 ? argv[2] : "")) {
    if (argc > 3 && c.name != argv[3]) continue;
    json["cases"].push_back(measure(c, wrong));
    std::fprintf(stderr, "%s: done\n", c.name.c_str());
    std::ofstream(argv[1]) << json.dump(1) << '\n';
  }
  if (wrong) std::fprintf(stderr, "a solution is further from the exact one than twice the goal\n");
  return wrong ? 1 : 0;
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: palpate_bench_dynamics JSON [SKULL_FOLDER [CASE]]\n");
    return 2;
  }
  return palpate::bench::run(argc, argv);
}
