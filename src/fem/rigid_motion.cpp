#include "fem/rigid_motion.hpp"

#include "fem/symmetric_eigen.hpp"

namespace palpate::fem {

RigidMotion rigid_motion(Range points, std::span<const double> masses, std::span<const Vec3> positions,
                         std::span<const Vec3> velocities) {
  double mass = 0.0;
  RigidMotion motion;
  for (Index i = points.begin; i < points.end; ++i) {
    const double m = at(masses, i);
    mass += m;
    motion.center += m * at(positions, i);
    motion.velocity += m * at(velocities, i);
  }
  motion.center = (1.0 / mass) * motion.center;
  motion.velocity = (1.0 / mass) * motion.velocity;
  Matrix3& inertia = motion.inertia;
  for (Index i = points.begin; i < points.end; ++i) {
    const double m = at(masses, i);
    const Vec3 arm = at(positions, i) - motion.center;
    const Vec3 velocity = at(velocities, i) - motion.velocity;
    motion.momentum += m * cross(arm, velocity);
    motion.deformation[0] += m * arm.x * velocity;
    motion.deformation[1] += m * arm.y * velocity;
    motion.deformation[2] += m * arm.z * velocity;
    motion.energy += 0.5 * m * squared_length(velocity);
    add_outer(inertia, -m, arm, arm);
    for (int k = 0; k < 3; ++k) inertia(k, k) += m * squared_length(arm);
  }
  motion.inverse_inertia = inverse(inertia);
  const Vec3 angular_velocity = motion.angular_velocity();
  const double half_trace = 0.5 * trace(inertia);
  for (int k = 0; k < 3; ++k) {
    Vec3 second_moment = -row(inertia, k);  // sum of m r_k r
    (k == 0 ? second_moment.x : k == 1 ? second_moment.y : second_moment.z) += half_trace;
    at(motion.deformation, k) -= cross(angular_velocity, second_moment);
  }
  return motion;
}

Vec3 free_angle(const RigidMotion& start, double time_step) {
  constexpr int parts = 4;
  const SymmetricEigen principal = symmetric_eigen(symmetric_part(start.inertia));
  const double middle = principal.values.y;
  const auto rate_beyond = [&](double inertia) { return 1.0 / inertia - 1.0 / middle; };
  const double largest = rate_beyond(principal.values.x);
  const double smallest = rate_beyond(principal.values.z);
  Quaternion body;
  const auto rotate = [&](const Vec3& axis, double rate, double fraction) {
    const Vec3 direction = rotated(body, axis);
    const double angle = fraction / parts * time_step * rate * dot(start.momentum, direction);
    body = product(rotation_by(angle * direction), body);
  };
  for (int i = 0; i < parts; ++i) {
    rotate(principal.vectors[0], largest, 0.5);
    rotate(principal.vectors[2], smallest, 1.0);
    rotate(principal.vectors[0], largest, 0.5);
  }
  return rotation_vector(product(rotation_by(time_step / middle * start.momentum), body));
}

}  // namespace palpate::fem
