// A damped isolated scene: three balls that run into each other without gravity. Oracle: the second law.
#include <algorithm>
#include <gtest/gtest.h>
#include <set>
#include <string>
#include <utility>

#include "fem/dynamics.hpp"
#include "geometry/vector.hpp"
#include "sim/response.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// The steps of a Simulation, which gives no bodies a speed at the start.
class CollidingBalls {
 public:
  CollidingBalls(double time_step, double friction, double contact_damping)
      : time_step_(time_step),
        bodies_(three_balls()),
        dynamics_(bodies_, materials_, std::vector<std::uint8_t>(bodies_.points_rest().size()), none_,
                  threads_),
        detector_(bodies_, {}, none_, 1),
        response_(bodies_, materials_, none_,
                  {.stiffness = stiffness_, .damping = contact_damping, .friction = friction},
                  dynamics_.point_masses(), dynamics_.free_points()) {
    std::vector<Vec3> velocities;
    for (const Index body : bodies_.body_of_point()) velocities.push_back({0.6 - 0.6 * body, 0.0, 0.0});
    dynamics_.set_velocities(velocities);
    detector_.detect(dynamics_.positions());
  }

  void step() {
    response_.compute(threads_, bodies_, detector_.contacts(), dynamics_.positions(), dynamics_.velocities(),
                      time_step_, couplings_);
    dynamics_.begin_step(time_step_, {}, {});
    int solves = 0;
    do {
      dynamics_.solve(couplings_, {1e-8, 3000});
    } while (++solves < 5 && response_.refine(threads_, dynamics_.end_velocities(), couplings_));
    dynamics_.end_step();
    detector_.detect(dynamics_.positions());
    count_contacts();
  }

  /// Motion, strain and the penalty springs, k d^2 / 2 each; not the springs of friction.
  double energy() { return dynamics_.kinetic_energy() + dynamics_.elastic_energy() + contact_energy_; }
  /// The springs' energy of contacts that were not there a step ago.
  [[nodiscard]] double new_contact_energy() const { return new_contact_energy_; }
  [[nodiscard]] std::size_t contacts() const { return detector_.contacts().size(); }

 private:
  static Bodies three_balls() {
    Bodies bodies;
    for (int i = 0; i < 3; ++i)
      bodies.add("ball " + std::to_string(i), test::ball_mesh(4, {0.12 * i, 0.01 * i, 0.005 * i}, 0.05));
    return bodies;
  }

  void count_contacts() {
    const Contacts& contacts = detector_.contacts();
    std::set<std::pair<Index, Index>> now;
    contact_energy_ = 0.0;
    new_contact_energy_ = 0.0;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const double spring = 0.5 * stiffness_ * contacts.depth[c] * contacts.depth[c];
      const std::pair key(contacts.point[c], contacts.body[c]);
      contact_energy_ += spring;
      if (!last_.contains(key)) new_contact_energy_ += spring;
      now.insert(key);
    }
    last_ = std::move(now);
  }

  static constexpr double stiffness_ = 500.0;
  double time_step_;
  std::vector<Material> materials_{
      3, Material{.young_modulus = 2e4, .mass_damping = 0.1, .stiffness_damping = 0.005}};
  std::vector<std::uint8_t> none_{0, 0, 0};
  parallel::Threads threads_{1};
  Bodies bodies_;
  fem::Dynamics dynamics_;
  Detector detector_;
  ContactResponse response_;
  std::vector<fem::Coupling> couplings_;
  std::set<std::pair<Index, Index>> last_;
  double contact_energy_ = 0.0;
  double new_contact_energy_ = 0.0;
};

/// A contact is found when the point is already inside: its spring begins stretched, with energy that nothing
/// has paid for. `counted` allows for just that.
void expect_no_growth(double time_step, double friction, double contact_damping, bool counted) {
  CollidingBalls balls(time_step, friction, contact_damping);
  const double first = balls.energy();
  double energy = first;
  std::size_t most_contacts = 0;
  for (int n = 0; n < 300; ++n) {
    balls.step();
    const double next = balls.energy();
    ASSERT_LE(next, energy * (1.0 + 1e-7) + (counted ? balls.new_contact_energy() : 0.0))
        << "step " << n << ", friction " << friction << ", time step " << time_step;
    ASSERT_LE(next, first);
    energy = next;
    most_contacts = std::max(most_contacts, balls.contacts());
  }
  EXPECT_GT(most_contacts, 10U);
  EXPECT_LT(energy, 0.7 * first);
}

TEST(Energy, OfADampedIsolatedSceneNeverGrows) {
  expect_no_growth(0.02, 0.0, 0.0, false);
  expect_no_growth(0.02, 0.3, 0.3, false);
  expect_no_growth(0.01, 0.0, 0.3, false);
  expect_no_growth(0.01, 0.3, 0.0, false);
}

TEST(Energy, WithShortStepsGrowsByNewContactsOnly) {
  expect_no_growth(0.005, 0.3, 0.3, true);
  expect_no_growth(0.002, 0.0, 0.0, true);
}

}  // namespace
}  // namespace palpate
