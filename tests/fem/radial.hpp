#pragma once

#include <Eigen/Dense>
#include <functional>

#include "fem/laws.hpp"

/// Deformations that depend on one radius: the minimum of the energy over r(R), by finite elements in one
/// dimension. They share no code with ours; the law is as its paper writes it.
namespace palpate::fem::test {

/// Integrand over R, as a function of R, r and dr/dR.
using RadialEnergy = std::function<Real(Real, Real, Real)>;

struct RadialSolution {
  Eigen::VectorXd r;         ///< at equal distances of R
  double inner_force = 0.0;  ///< derivative of the energy by r at the inner end
  double energy = 0.0;
  double inner = 0.0;
  double outer = 0.0;
  [[nodiscard]] double at(double radius) const {
    const double x = (radius - inner) / (outer - inner) * static_cast<double>(r.size() - 1);
    const auto i = std::min(static_cast<Eigen::Index>(std::max(x, 0.0)), r.size() - 2);
    const double s = x - static_cast<double>(i);
    return (1.0 - s) * r[i] + s * r[i + 1];
  }
};

class RadialProblem {
 public:
  RadialProblem(RadialEnergy energy, double inner, double outer, int elements)
      : energy_(std::move(energy)), inner_(inner), outer_(outer), count_(elements) {}

  /// \param start  r of the first guess
  /// \param hold   r at the inner end is fixed
  [[nodiscard]] RadialSolution solve(const std::function<double(double)>& start, bool hold) const {
    Eigen::VectorXd r(count_ + 1);
    for (int i = 0; i <= count_; ++i) r[i] = start(node(i));
    for (int n = 0; n < 40; ++n) {
      assemble(r);
      const double force = gradient_[0];
      if (hold) {
        hessian_.row(0).setZero();
        hessian_.col(0).setZero();
        hessian_(0, 0) = 1.0;
        gradient_[0] = 0.0;
      }
      const Eigen::VectorXd step = hessian_.ldlt().solve(gradient_);
      r -= step;
      if (step.norm() < 1e-13 * r.norm()) return {r, force, total_, inner_, outer_};
    }
    throw std::runtime_error("no convergence of the radial problem");
  }

 private:
  [[nodiscard]] double node(int i) const { return inner_ + (outer_ - inner_) * i / count_; }
  /// Integrates by the midpoint of each element, which does not lock at constant volume.
  void assemble(const Eigen::VectorXd& r) const {
    gradient_.setZero(count_ + 1);
    hessian_.setZero(count_ + 1, count_ + 1);
    total_ = 0.0;
    const double h = (outer_ - inner_) / count_;
    for (int i = 0; i < count_; ++i)
      add(0.5 * (node(i) + node(i + 1)), {0.5, 0.5}, {-1.0 / h, 1.0 / h}, h, r, i);
  }
  void add(double radius, const Eigen::Vector2d& value, const Eigen::Vector2d& slope, double weight,
           const Eigen::VectorXd& r, int i) const {
    const Eigen::Vector2d ends = r.segment<2>(i);
    const Real x = value.dot(ends);
    const Real y = slope.dot(ends);
    const Real d = 1e-4L;
    const Real dx = d * std::abs(x) + 1e-8L;
    const auto w = [&](Real a, Real b) { return energy_(radius, x + a * dx, y + b * d); };
    const Real middle = w(0, 0);
    const auto first = [&](int a, int b, Real step) {
      return (8 * (w(a, b) - w(-a, -b)) - (w(2 * a, 2 * b) - w(-2 * a, -2 * b))) / (12 * step);
    };
    const double wx = static_cast<double>(first(1, 0, dx));
    const double wy = static_cast<double>(first(0, 1, d));
    const double wxx = static_cast<double>((w(1, 0) - 2 * middle + w(-1, 0)) / (dx * dx));
    const double wyy = static_cast<double>((w(0, 1) - 2 * middle + w(0, -1)) / (d * d));
    const double wxy = static_cast<double>((w(1, 1) - w(1, -1) - w(-1, 1) + w(-1, -1)) / (4 * dx * d));
    total_ += weight * static_cast<double>(middle);
    gradient_.segment<2>(i) += weight * (wx * value + wy * slope);
    hessian_.block<2, 2>(i, i) +=
        weight * (wxx * value * value.transpose() + wyy * slope * slope.transpose() +
                  wxy * (value * slope.transpose() + slope * value.transpose()));
  }

  RadialEnergy energy_;
  double inner_;
  double outer_;
  int count_;
  mutable Eigen::VectorXd gradient_;
  mutable Eigen::MatrixXd hessian_;
  mutable double total_ = 0.0;
};

}  // namespace palpate::fem::test
