// Contacts in a step. Oracles: differences of the force for its derivative; conjugate gradients if all
// contacts stick, so that the step is linear; the balance of momentum of each body and Coulomb's law if they
// slide and separate; for the reduced problem, sums written out.
#include <cmath>
#include <gtest/gtest.h>

#include "fem/contact_law.hpp"
#include "fem/meshes.hpp"
#include "fem/reduced_step.hpp"
#include "fem/system.hpp"
#include "simd/contact_rates.hpp"
#include "simd/direction_rows.hpp"
#include "support/random.hpp"
#include "support/simd_targets.hpp"

namespace palpate::fem::test {
namespace {

constexpr StepFriction friction{.coefficient = 0.4, .time_step = 0.01};

ContactLaw random_law(palpate::test::Random& random) {
  const Vec3 direction = normalized(random.point(-1, 1));
  const Vec3 slip = random.point(-1e-3, 1e-3);
  return {.stiffness = 100.0 * (1.0 + std::abs(random.point(-1, 1).x)),
          .damping = 1.0,
          .depth = 0.02 * random.point(-1, 1).y,
          .slip = slip - dot(slip, direction) * direction,
          .direction = direction};
}

/// By hand from Coulomb's law: friction with another bound.
Vec3 force_with_bound(const ContactLaw& law, const Vec3& u, double bound) {
  const ContactForce force = contact_force(law, friction, u);
  const double pull = length(force.pull);
  return force.normal * law.direction + (pull > bound ? (bound / pull) * force.pull : force.pull);
}

/// Laws, states and the results of the kernels.
struct LawList {
  void add(const ContactLaw& law, const Vec3& velocity, double bound) {
    laws.push_back(law);
    u.push_back(velocity);
    bounds.push_back(bound);
  }
  [[nodiscard]] simd::ContactLawRows rows(bool with_bounds) {
    put_in_rows(laws, friction.time_step, values);
    return {.values = values.data(),
            .friction = friction.coefficient,
            .bounds = with_bounds ? bounds.data() : nullptr};
  }
  std::vector<ContactLaw> laws;
  std::vector<Vec3> u;
  std::vector<double> bounds;
  simd::AlignedVector<double> values;
};

/// Whole groups of laws that are open, stick and slide, and some without tangential force.
LawList random_laws(std::size_t count) {
  palpate::test::Random random(7);
  LawList list;
  for (std::size_t k = 0; k < count; ++k) {
    ContactLaw law = random_law(random);
    Vec3 u = random.point(-0.5, 0.5);
    if (k % 16 == 5) {
      law.slip = {};
      u = 0.1 * law.direction;
    }
    list.add(law, u, k % 3 == 0 ? 0.0 : 0.3);
  }
  return list;
}

TEST(ContactLaw, DerivativesAreThoseOfTheForces) {
  LawList list = random_laws(320);
  std::vector<Matrix3> full(list.u.size());
  std::vector<Matrix3> convex(list.u.size());
  simd::contact_derivatives(list.rows(false), list.u.data(), full.front().values.data(), 0, list.u.size());
  simd::contact_derivatives(list.rows(true), list.u.data(), convex.front().values.data(), 0, list.u.size());
  std::array<int, 3> seen{};  // open, stick, slide
  for (std::size_t k = 0; k < list.u.size(); ++k) {
    if (k % 16 == 5) continue;  // no derivative where the tangential force is zero
    const ContactLaw& law = list.laws[k];
    const ContactForce force = contact_force(law, friction, list.u[k]);
    const bool slides = length(force.pull) > friction.coefficient * force.normal;
    ++seen[force.normal == 0.0 ? 0 : slides ? 2 : 1];
    constexpr double step = 1e-6;
    const std::array axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    for (const Vec3& axis : axes) {
      const Vec3 a = list.u[k] + step * axis;
      const Vec3 b = list.u[k] - step * axis;
      const auto whole = [&](const Vec3& v) { return contact_force(law, friction, v).whole(law.direction); };
      const Vec3 found = (0.5 / step) * (whole(b) - whole(a));
      const Vec3 bounded = (0.5 / step) * (force_with_bound(law, b, list.bounds[k]) -
                                           force_with_bound(law, a, list.bounds[k]));
      EXPECT_LT(length(full[k] * axis - found), 1e-4) << k;
      EXPECT_LT(length(convex[k] * axis - bounded), 1e-4) << k;
    }
    EXPECT_LE(length(force.friction), friction.coefficient * force.normal * (1.0 + 1e-15));
    EXPECT_GE(force.normal, 0.0);
  }
  for (const int count : seen) EXPECT_GT(count, 20);
}

TEST(ContactLaw, KernelsHaveTheSameBitsOnEveryTarget) {
  LawList list = random_laws(40);
  const std::size_t count = list.u.size();
  palpate::test::Random random(23);
  std::vector<Vec3> base(count);
  for (Vec3& f : base) f = random.point(-0.5, 0.5);
  for (const bool with_bounds : {false, true}) {
    std::vector<Matrix3> expected(count);
    simd::scalar::contact_derivatives(list.rows(with_bounds), list.u.data(), expected.front().values.data(),
                                      0, count);
    const auto check = [&](auto forces, auto derivatives, const char* target) {
      std::vector<Vec3> f(count);
      std::vector<Matrix3> h(count);
      forces(list.rows(with_bounds), list.u.data(), base.data(), f.data(), 0, count);
      derivatives(list.rows(with_bounds), list.u.data(), h.front().values.data(), 0, count);
      EXPECT_EQ(h, expected) << target;
      for (std::size_t k = 0; k < count; ++k) {
        const ContactLaw& law = list.laws[k];
        const Vec3 whole = with_bounds ? force_with_bound(law, list.u[k], list.bounds[k])
                                       : contact_force(law, friction, list.u[k]).whole(law.direction);
        EXPECT_EQ(f[k], whole - base[k]) << target << ' ' << k;
      }
    };
    check(simd::scalar::contact_forces, simd::scalar::contact_derivatives, "scalar");
    palpate::test::for_each_simd_target(
        [&](const char* target) { check(simd::contact_forces, simd::contact_derivatives, target); });
  }
}

/// Rounds like the stored rates of contacts.
Vec3 rounded_to_float(const Vec3& a) {
  const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
  return {rounded(a.x), rounded(a.y), rounded(a.z)};
}

/// Random contacts in the span of random directions.
struct RandomStep {
  std::vector<ContactLaw> laws;
  std::vector<Vec3> base;
  std::vector<std::vector<Vec3>> rates;  ///< of each direction
  std::vector<double> g;
  std::vector<std::vector<double>> gram;

  RandomStep(std::uint64_t seed, std::size_t contacts, std::size_t directions, double stiffness = 1.0)
      : base(contacts),
        rates(directions, std::vector<Vec3>(contacts)),
        g(directions),
        gram(directions, std::vector<double>(directions)) {
    palpate::test::Random random(seed);
    for (std::size_t k = 0; k < contacts; ++k) {
      laws.push_back(random_law(random));
      laws.back().stiffness *= stiffness;
    }
    for (Vec3& u : base) u = random.point(-0.3, 0.3);
    for (std::size_t i = 0; i < directions; ++i) {
      for (Vec3& j : rates[i]) j = rounded_to_float(random.point(-1, 1));
      g[i] = 5.0 * random.point(-1, 1).x;
      for (std::size_t l = 0; l < i; ++l) gram[i][l] = gram[l][i] = 0.05 * random.point(-1, 1).x;
      gram[i][i] = 1.0;
    }
  }

  void begin(const parallel::Threads& team, ReducedStep& step) const {
    step.begin(16);
    step.set_contacts(laws, friction);
    for (std::size_t k = 0; k < laws.size(); ++k) step.set_base(k, base[k]);
    step.update(team);
  }
  void add(ReducedStep& step, std::size_t direction) const {
    double work = 0.0;
    for (std::size_t k = 0; k < laws.size(); ++k) work += step.set_rate(k, direction, rates[direction][k]);
    step.add(std::span(gram[direction]).first(direction + 1), g[direction], work);
  }
  /// |F|, by sums written out.
  [[nodiscard]] double residual(std::span<const double> c) const {
    double square = 0.0;
    for (std::size_t i = 0; i < c.size(); ++i) {
      double sum = g[i];
      for (std::size_t l = 0; l < c.size(); ++l) sum -= gram[i][l] * c[l];
      for (std::size_t k = 0; k < laws.size(); ++k) {
        Vec3 u = base[k];
        for (std::size_t l = 0; l < c.size(); ++l) u += c[l] * rates[l][k];
        const Vec3 more = contact_force(laws[k], friction, u).whole(laws[k].direction) -
                          contact_force(laws[k], friction, base[k]).whole(laws[k].direction);
        sum += friction.time_step * dot(rates[i][k], more);
      }
      square += sum * sum;
    }
    return std::sqrt(square);
  }
};

TEST(ReducedStep, BringsTheResidualOfTheWholeToZero) {
  constexpr std::size_t contacts = 150;
  constexpr std::size_t directions = 11;
  const RandomStep problem(11, contacts, directions);
  std::vector<double> expected;
  for (const int threads : {1, 3}) {
    ReducedStep step;
    const parallel::Threads team(threads);
    problem.begin(team, step);
    for (std::size_t i = 0; i < directions; ++i) {
      problem.add(step, i);
      ASSERT_TRUE(step.solve(team));
    }
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(step.solve(team));
    EXPECT_LT(problem.residual(step.solution()), 1e-7 * problem.residual(std::vector<double>(directions)));
    const std::vector<double> found(step.solution().begin(), step.solution().end());
    if (threads == 1) expected = found;
    EXPECT_EQ(found, expected) << "the same bits";
    // A direction that exists already is refused, and changes nothing.
    std::vector<double> again = problem.gram[directions - 1];
    again.push_back(problem.gram[directions - 1][directions - 1]);
    double work = 0.0;
    for (std::size_t k = 0; k < contacts; ++k)
      work += step.set_rate(k, directions, problem.rates[directions - 1][k]);
    step.add(again, problem.g[directions - 1], work);
    EXPECT_FALSE(step.solve(team));
    EXPECT_EQ(std::vector<double>(step.solution().begin(), step.solution().end()), found);
  }
}

/// Contacts far stiffer than their bodies. A call ends when |F| has fallen to a tenth. So where Newton's
/// method is enough, it takes several calls to solve a problem up to rounding; with the forces as unknowns,
/// one.
TEST(ReducedStep, SolvesAFewContactsWithTheirForcesAsUnknowns) {
  const parallel::Threads team(1);
  constexpr std::size_t directions = 9;
  constexpr int cases = 300;
  int by_one_call = 0;
  int by_ten_calls = 0;
  for (int i = 0; i < cases; ++i) {
    const auto contacts = static_cast<std::size_t>(1 + i % 30);
    const RandomStep problem(static_cast<std::uint64_t>(i), contacts, directions, 1e4);
    ReducedStep step;
    problem.begin(team, step);
    for (std::size_t d = 0; d < directions; ++d) problem.add(step, d);
    const double goal = 1e-7 * problem.residual(std::vector<double>(directions));
    ASSERT_TRUE(step.solve(team));
    by_one_call += problem.residual(step.solution()) < goal ? 1 : 0;
    for (int k = 1; k < 10; ++k) ASSERT_TRUE(step.solve(team));
    by_ten_calls += problem.residual(step.solution()) < goal ? 1 : 0;
  }
  EXPECT_GE(by_one_call, 70);  // found 79; 48 without the forces as unknowns
  EXPECT_GE(by_ten_calls, cases);
}

TEST(DirectionRows, HaveTheSameBitsOnEveryTarget) {
  palpate::test::Random random(5);
  constexpr std::size_t contacts = 37;
  constexpr std::size_t stride = 24;
  std::vector<double> values(3 * stride * contacts);
  std::vector<float> single(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    single[i] = static_cast<float>(random.point(-1, 1).x);
    values[i] = static_cast<double>(single[i]);
  }
  const simd::ContactRates rates{.values = single.data(), .stride = stride, .n = 16};
  std::vector<float> a(16 * 48);
  std::vector<float> b(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = static_cast<float>(random.point(-1, 1).x);
    b[i] = static_cast<float>(random.point(-1, 1).y);
  }
  std::vector<double> weights(9 * contacts);
  for (double& value : weights) value = random.point(-1, 1).z;
  std::fill_n(weights.begin() + 9, 9, 0.0);
  std::vector<Vec3> vectors(contacts);
  for (Vec3& v : vectors) v = random.point(-1, 1);
  const auto run = [&](auto dot_of, auto dot_two_of, auto subtract, auto combine_vectors, auto combine,
                       auto project, auto add, auto add_row) {
    std::vector<double> results{dot_of(a.data(), b.data(), a.size())};
    const simd::TwoSums sums = dot_two_of(a.data(), b.data(), a.data(), a.size());
    results.insert(results.end(), {sums.first, sums.second});
    std::vector<float> c = a;
    const std::array<float, 3> scales{0.3F, -0.7F, 1.9F};
    const simd::FloatVectors parts{.values = b.data(), .stride = 48, .count = 3};
    subtract(parts, scales.data(), c.data(), c.size() - 96);
    results.insert(results.end(), c.begin(), c.end());
    std::vector<double> combined(b.size() - 96);
    combine_vectors(parts, values.data(), combined.data(), combined.size());
    results.insert(results.end(), combined.begin(), combined.end());
    std::vector<Vec3> u(contacts);
    combine(rates, values.data(), u.data(), 1, contacts);
    for (const Vec3& v : u) results.insert(results.end(), {v.x, v.y, v.z});
    std::vector<double> sum(stride * stride + 2 * stride);
    project(rates, vectors.data(), sum.data(), 0, contacts);
    add(rates, weights.data(), sum.data(), 0, contacts);
    add_row(rates, weights.data(), 3, sum.data() + stride * stride, sum.data() + stride * stride + stride, 0,
            contacts);
    results.insert(results.end(), sum.begin(), sum.end());
    // One entry of J^T H J by its definition, and the same entry in row and column.
    double entry = 0.0;
    for (std::size_t k = 0; k < contacts; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
          entry += values[stride * (3 * k + i) + 3] * weights[9 * k + 3 * i + j] *
                   values[stride * (3 * k + j) + 5];
      }
    }
    EXPECT_NEAR(sum[stride * 3 + 5], entry, 1e-12);
    EXPECT_NEAR(sum[stride * stride + 5], entry, 1e-12);
    return results;
  };
  const auto twin =
      run(simd::scalar::dot_floats, simd::scalar::dot_two, simd::scalar::subtract_combination,
          simd::scalar::combine_in_double, simd::scalar::combine_rates, simd::scalar::project_forces,
          simd::scalar::add_stiffness, simd::scalar::add_stiffness_row);
  palpate::test::for_each_simd_target([&](const char* target) {
    EXPECT_EQ(run(simd::dot_floats, simd::dot_two, simd::subtract_combination, simd::combine_in_double,
                  simd::combine_rates, simd::project_forces, simd::add_stiffness, simd::add_stiffness_row),
              twin)
        << target;
  });
}

/// Blocks on each other, the lowest one held, with contacts between their faces.
struct Tower {
  static constexpr int count = 5;
  explicit Tower(int thread_count, double depth, double mu) : threads(thread_count) {
    step = {.coefficient = mu, .time_step = 0.01};
    for (int i = 0; i < count; ++i) {
      TetMesh mesh = box_mesh({2, 2, 2}, {0.04, 0.04, 0.04});
      for (Vec3& p : mesh.points) p.z += 0.04 * i;
      bodies.add("block " + std::to_string(i), mesh);
    }
    const std::vector<std::uint8_t> held = select(bodies, [](const Vec3& p) { return p.z == 0.0; });
    dynamics = std::make_unique<Dynamics>(bodies, std::vector<Material>(count, {1e6, 0.3, 1000.0, 0.0, 1e-3}),
                                          held, std::vector<std::uint8_t>(count, 0), threads);
    for (int i = 0; i + 1 < count; ++i) {
      for (Index k = 0; k < 9; ++k) {
        Coupling contact;
        contact.points[0] = 27 * (i + 1) + k;
        contact.points[1] = 27 * i + 18 + k;
        contact.coefficients = {1.0, -1.0};
        couplings.push_back(contact);
        laws.push_back(
            {.stiffness = 2e3, .damping = 5.0, .depth = depth, .slip = {}, .direction = {0.0, 0.0, 1.0}});
      }
    }
  }
  SolveReport solve(const Vec3& gravity, const SolveGoal& goal, bool steady = false) {
    dynamics->begin_step(step.time_step, gravity, {});
    return dynamics->solve({.laws = laws, .couplings = couplings, .first = 0, .friction = step}, goal,
                           steady);
  }
  parallel::Threads threads;
  Bodies bodies;
  std::unique_ptr<Dynamics> dynamics;
  std::vector<Coupling> couplings;
  std::vector<ContactLaw> laws;
  StepFriction step{};
};

constexpr SolveGoal tight{.tolerance = 1e-9,
                          .max_iterations = 3000,
                          .of_solution = true,
                          .preconditioner = Preconditioner::automatic};

TEST(ContactSolver, IsConjugateGradientsWhereAllContactsHold) {
  for (const Preconditioner preconditioner :
       {Preconditioner::jacobi, Preconditioner::multigrid, Preconditioner::automatic}) {
    SolveGoal goal = tight;
    goal.preconditioner = preconditioner;
    Tower tower(2, 0.02, 1e6);
    Tower linear(2, 0.02, 1e6);
    const Vec3 gravity{0.3, 0.0, -9.81};
    EXPECT_TRUE(tower.solve(gravity, goal).converged);
    for (std::size_t c = 0; c < linear.couplings.size(); ++c) {
      const double k = linear.laws[c].stiffness;
      const double d = linear.laws[c].damping;
      linear.couplings[c].force = k * linear.laws[c].depth * linear.laws[c].direction;
      linear.couplings[c].stiffness = {k, k, k, 0, 0, 0};
      linear.couplings[c].damping = {d, d, d, 0, 0, 0};
    }
    linear.dynamics->begin_step(linear.step.time_step, gravity, {});
    EXPECT_TRUE(linear.dynamics->solve(linear.couplings, goal).converged);
    const Eigen::VectorXd expected = to_eigen(linear.dynamics->mean_velocities());
    EXPECT_LT((to_eigen(tower.dynamics->mean_velocities()) - expected).norm(), 1e-7 * expected.norm());
    for (std::size_t c = 0; c < linear.couplings.size(); ++c) {
      const Vec3 force = end_force(linear.couplings[c], 0.01, linear.dynamics->mean_velocities());
      EXPECT_LT(length(tower.couplings[c].force - force), 1e-6 * length(force));
    }
  }
}

TEST(ContactSolver, BalancesMomentumWhereContactsSlideAndLetGo) {
  // The tower is tilted: pulled sideways hard enough to slide, and some contacts start open.
  std::vector<Vec3> expected;
  for (const int threads : {1, 2}) {
    Tower tower(threads, 1e-4, 0.3);
    for (std::size_t c = 0; c < tower.laws.size(); c += 3) tower.laws[c].depth = -1e-4;
    const Vec3 gravity{6.0, 1.0, -9.81};
    ASSERT_TRUE(tower.solve(gravity, tight).converged);
    int open = 0;
    int sliding = 0;
    std::array<Vec3, Tower::count> impulses{};
    for (std::size_t c = 0; c < tower.couplings.size(); ++c) {
      const Vec3& force = tower.couplings[c].force;
      open += force == Vec3{} ? 1 : 0;
      const double across = std::hypot(force.x, force.y);
      EXPECT_LE(across, 0.3 * force.z * (1.0 + 1e-12));
      sliding += force.z > 0.0 && across > 0.2999 * force.z ? 1 : 0;
      const std::size_t lower = c / 9;
      impulses[lower + 1] += 0.01 * force;
      impulses[lower] -= 0.01 * force;
    }
    EXPECT_GT(open, 0);
    EXPECT_GT(sliding, 5);
    for (std::size_t b = 1; b < Tower::count; ++b) {
      const Range points = tower.bodies.bodies()[b].points;
      Vec3 momentum;
      Vec3 weight;
      for (Index p = points.begin; p < points.end; ++p) {
        const double m = at(tower.dynamics->point_masses(), p);
        momentum += m * at(tower.dynamics->mean_velocities(), p);
        weight += m * gravity;
      }
      const Vec3 off = momentum - 0.01 * weight - impulses[b];
      EXPECT_LT(length(off), 1e-7 * length(0.01 * weight)) << b;
    }
    const auto found = tower.dynamics->mean_velocities();
    if (threads == 1) expected.assign(found.begin(), found.end());
    EXPECT_EQ(std::vector<Vec3>(found.begin(), found.end()), expected) << "the same bits";
  }
}

}  // namespace
}  // namespace palpate::fem::test
