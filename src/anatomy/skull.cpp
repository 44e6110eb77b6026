#include <string>
#include <utility>
#include <vector>

#include "anatomy/fit.hpp"
#include "anatomy/organs.hpp"
#include "anatomy/round_points.hpp"
#include "anatomy/shapes.hpp"
#include "anatomy/stuffing.hpp"

namespace palpate::anatomy {
namespace {

constexpr double skull_gap = 0.25;
constexpr double tissue = 10.0;  ///< thickness of the soft tissue
constexpr double tissue_back = 22.0;

/// Head without its nose.
Distance head_shape() {
  return smoothly_united(ellipsoid({0.0, 8.0, 15.0}, {74.0, 96.0, 100.0}),
                         ellipsoid({0.0, -25.0, -62.0}, {60.0, 66.0, 52.0}), 30.0);
}

/// The part of the head's volume between two depths, two heights, and two positions from front to back.
Distance part(double thickness, double bottom, double top, double front, double back) {
  constexpr double wide = 100.0;
  return common(
      {layer(head_shape(), -tissue - thickness, -tissue), box({-wide, front, bottom}, {wide, back, top})});
}

Distance skull_shape() {
  Distance skull = part(8.8, -20.0, 55.0, -100.0, 18.0);
  for (const double side : {-1.0, 1.0})
    skull = without(std::move(skull), ball({side * 30.0, -72.0, 8.0}, 17.0));
  return without(std::move(skull), ellipsoid({0.0, -76.0, -20.0}, {11.0, 30.0, 15.0}));
}

Distance upper_jaw_shape() {
  return part(8.2, -50.0, -24.0, -100.0, -22.0);
}

Distance lower_jaw_shape() {
  return united({part(8.2, -91.0, -55.0, -100.0, 20.0), part(8.2, -91.0, -26.0, -6.0, 20.0)});
}

Distance soft_tissue_shape() {
  const Distance nose = ellipsoid({0.0, -90.0, -18.0}, {13.0, 20.0, 24.0});
  const Distance outer = smoothly_united(head_shape(), nose, 14.0);
  const Distance inner = grown(head_shape(), skull_gap - tissue);
  return without(common({outer, box({-100.0, -140.0, -100.0}, {100.0, tissue_back, 60.0})}), inner);
}

/// The mesh of a shape that is widened first by `widening`, so that thin parts and edges stay whole.
Organ meshed(std::string name, const Distance& shape, double cell, double widening) {
  Organ organ{std::move(name), stuff_fitted(shape, grown(shape, widening),
                                            {{-90.0, -130.0, -120.0}, {90.0, 60.0, 100.0}, cell})};
  round_points(organ.mesh);
  return organ;
}

}  // namespace

std::vector<Organ> make_skull() {
  return {meshed("skull", skull_shape(), 8.6, 1.2), meshed("upper-jaw", upper_jaw_shape(), 7.4, 1.0),
          meshed("lower-jaw", lower_jaw_shape(), 7.5, 1.0),
          meshed("soft-tissue", soft_tissue_shape(), 8.7, 0.8)};
}

}  // namespace palpate::anatomy
