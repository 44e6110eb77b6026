#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>

#include <palpate/error.hpp>

#include "scene/generators.hpp"

namespace palpate {
namespace {

/// Uniform in [-1, 1], a hash of (seed, index, channel): the finaliser of SplitMix64 (Steele, Lea, Flood
/// 2014).
double random_unit(std::uint32_t seed, int index, std::uint32_t channel) {
  std::uint64_t z = (std::uint64_t{seed} << 32U) + static_cast<std::uint64_t>(index) * 4U + channel;
  z = (z + 1) * 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  z ^= z >> 31U;
  return std::ldexp(static_cast<double>(z >> 11U), -52) - 1.0;
}

/// x rounded to `digits` decimal digits, so that the scene file is easy to read.
double rounded_to(double x, int digits) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.begin(), text.end(), x, std::chars_format::scientific, digits - 1).ptr;
  double result = 0.0;
  std::from_chars(text.begin(), end, result);
  return result;
}

double random_within(double bound, std::uint32_t seed, int index, std::uint32_t channel) {
  constexpr int digits = 4;
  return std::clamp(rounded_to(bound * random_unit(seed, index, channel), digits), -bound, bound);
}

void check(const StackingOptions& options) {
  const auto refuse = [](const char* what, double found, const char* expected) {
    throw Error("make_stacking_scene", what, std::to_string(found), expected);
  };
  const auto non_negative = [](double x) { return std::isfinite(x) && x >= 0.0; };
  constexpr int most = 100'000;
  if (options.count < 1 || options.count > most) refuse("count", options.count, "1 to 100000");
  if (!non_negative(options.gap)) refuse("gap", options.gap, "a number >= 0");
  if (!non_negative(options.max_shift)) refuse("max_shift", options.max_shift, "a number >= 0");
  if (!non_negative(options.max_rotation)) refuse("max_turn", options.max_rotation, "a number >= 0");
}

SceneBody membrane(const StackingOptions& options, int index) {
  SceneBody body;
  body.name = "membrane " + std::to_string(index);
  body.source = BoxGenerator{options.cells, options.size};
  body.transform.translate.z = rounded_to(0.5 * options.size.z + index * (options.size.z + options.gap), 12);
  if (index == 0) {
    body.obstacle = true;
    return body;
  }
  body.transform.translate.x = random_within(options.max_shift, options.seed, index, 0);
  body.transform.translate.y = random_within(options.max_shift, options.seed, index, 1);
  body.transform.rotate.angle = random_within(options.max_rotation, options.seed, index, 2);
  body.material = Material{.young_modulus = 20e3,
                           .poisson_ratio = 0.4,
                           .density = 1000.0,
                           .mass_damping = 1.0,
                           .stiffness_damping = 2e-3};
  return body;
}

}  // namespace

Scene make_stacking_scene(const StackingOptions& options) {
  check(options);
  make_box(options.cells, options.size);  // throws Error if such a box cannot be made
  Scene scene;
  scene.name = "stacking";
  scene.source = "make_stacking_scene";
  scene.settings.time_step = 0.005;  // a membrane falls less than half its thickness in a step
  scene.settings.response.friction = 0.3;
  // The paper has only contacts of points, at the ends of steps.
  scene.settings.detection.edge_contacts = false;
  scene.settings.detection.continuous = ContinuousDetection::off;
  scene.duration = 5.0;
  for (int i = 0; i < options.count; ++i) scene.bodies.push_back(membrane(options, i));
  return scene;
}

}  // namespace palpate
