#include "lattice.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "components.hpp"
#include "thinner.hpp"

namespace palpate::app {
namespace {

/// The cell that contains a coordinate, and its fraction within the cell along one axis. Coordinates beyond
/// the lattice are moved to its end.
struct Place {
  int cell;
  double fraction;
};

Place place_of(double x, double origin, double spacing, int size) {
  const double steps = std::clamp((x - origin) / spacing, 0.0, static_cast<double>(size - 1));
  const int cell = std::min(static_cast<int>(steps), size - 2);
  return {cell, steps - cell};
}

double interpolate(double a, double b, double fraction) {
  return a + (b - a) * fraction;
}

/// The eight corner values of a cell, x fastest.
std::array<double, 8> corners(const Lattice& lattice, int i, int j, int k) {
  std::array<double, 8> values{};
  for (std::size_t c = 0; c < 8; ++c) {
    const int corner = static_cast<int>(c);
    values[c] = static_cast<double>(
        lattice.values[lattice.index(i + corner % 2, j + corner / 2 % 2, k + corner / 4)]);
  }
  return values;
}

/// Trilinear interpolation of the corner values at x, y, z in [0, 1].
double value_in_cell(const std::array<double, 8>& v, double x, double y, double z) {
  const double low = interpolate(interpolate(v[0], v[1], x), interpolate(v[2], v[3], x), y);
  const double high = interpolate(interpolate(v[4], v[5], x), interpolate(v[6], v[7], x), y);
  return interpolate(low, high, z);
}

constexpr int samples = 2;  // samples of a cell along each axis

/// Calls f(value, range) for each subcell: the value at its centre, and the range of values within it.
template <class Function>
void for_samples(const std::array<double, 8>& cell, Function&& f) {
  for_points({samples, samples, samples}, [&](int i, int j, int k) {
    const auto at = [&](double x, double y, double z) {
      return value_in_cell(cell, (i + x) / samples, (j + y) / samples, (k + z) / samples);
    };
    const double range = std::abs(at(1, 0.5, 0.5) - at(0, 0.5, 0.5)) +
                         std::abs(at(0.5, 1, 0.5) - at(0.5, 0, 0.5)) +
                         std::abs(at(0.5, 0.5, 1) - at(0.5, 0.5, 0));
    f(at(0.5, 0.5, 0.5), range);
  });
}

/// A histogram with bins of equal width. A sample is spread evenly over its range, so that a flat surface
/// between two samples is counted at its exact position. Counts are kept as differences between bins.
class Histogram {
 public:
  Histogram(double low, double high) : low_(low), width_((high - low) / bins), starts_(bins + 2) {}

  void add(double value, double range, double times) {
    if (range < width_) {
      const double bin = std::clamp(std::floor((value - low_) / width_), 0.0, bins - 1.0);
      starts_[static_cast<std::size_t>(bin)] += times;
      starts_[static_cast<std::size_t>(bin) + 1] -= times;
    } else {
      step(value - 0.5 * range, times * width_ / range);
      step(value + 0.5 * range, -times * width_ / range);
    }
  }
  /// The value above which there are `count` samples.
  [[nodiscard]] double level(double count) const {
    std::vector<double> counts;
    counts.reserve(starts_.size());
    double here = 0.0;
    for (const double start : starts_) counts.push_back(here += start);
    for (int bin = bins; bin >= 0; --bin) {
      const double in_bin = counts[static_cast<std::size_t>(bin)];
      if (in_bin >= count && in_bin > 0.0) return low_ + width_ * (bin + 1 - count / in_bin);
      count -= in_bin;
    }
    return low_;
  }

 private:
  static constexpr int bins = 4096;
  /// Adds `count` to every bin above `from`.
  void step(double from, double count) {
    const double place = std::clamp((from - low_) / width_, 0.0, static_cast<double>(bins));
    const auto bin = static_cast<std::size_t>(place);
    const double over = place - static_cast<double>(bin);
    starts_[bin] += count * (1.0 - over);
    starts_[bin + 1] += count * over;
  }
  double low_;
  double width_;
  std::vector<double> starts_;
};

std::array<int, 3> cells_of(const Lattice& lattice) {
  return {lattice.size[0] - 1, lattice.size[1] - 1, lattice.size[2] - 1};
}

double sample_volume(const Lattice& lattice) {
  return lattice.spacing.x * lattice.spacing.y * lattice.spacing.z / (samples * samples * samples);
}

/// Connected components of the positive points.
Components positive_components(const Lattice& lattice) {
  std::vector<std::uint16_t> positive;
  positive.reserve(lattice.values.size());
  for (const float value : lattice.values) positive.push_back(value > 0.0F ? 1 : 0);
  return components_of(lattice.size, positive);
}

}  // namespace

double Lattice::operator()(const Vec3& p) const {
  const Place x = place_of(p.x, origin.x, spacing.x, size[0]);
  const Place y = place_of(p.y, origin.y, spacing.y, size[1]);
  const Place z = place_of(p.z, origin.z, spacing.z, size[2]);
  return value_in_cell(corners(*this, x.cell, y.cell, z.cell), x.fraction, y.fraction, z.fraction);
}

double level_of_volume(const Lattice& lattice, double volume) {
  const auto [least, most] = std::ranges::minmax(lattice.values);
  if (!(least < most)) return static_cast<double>(least);
  Histogram values(static_cast<double>(least), static_cast<double>(most));
  for_points(cells_of(lattice), [&](int i, int j, int k) {
    const std::array<double, 8> cell = corners(lattice, i, j, k);
    const auto [low, high] = std::ranges::minmax(cell);
    if (low == high) {
      values.add(low, 0.0, samples * samples * samples);
    } else {
      for_samples(cell, [&](double value, double range) { values.add(value, range, 1.0); });
    }
  });
  return values.level(volume / sample_volume(lattice));
}

double positive_volume(const Lattice& lattice) {
  double count = 0.0;
  for_points(cells_of(lattice), [&](int i, int j, int k) {
    const std::array<double, 8> cell = corners(lattice, i, j, k);
    const auto [least, most] = std::ranges::minmax(cell);
    if (least > 0.0) {
      count += samples * samples * samples;
    } else if (most > 0.0) {
      for_samples(cell, [&](double value, double range) {
        const double tiny = 1e-12 * most;
        count += std::clamp(value / std::max(range, tiny) + 0.5, 0.0, 1.0);
      });
    }
  });
  return count * sample_volume(lattice);
}

SurfaceSeeds surface_seeds(const Lattice& lattice, double spacing) {
  const Components components = positive_components(lattice);
  std::vector<Thinner> thinners;
  const double point_volume = lattice.spacing.x * lattice.spacing.y * lattice.spacing.z;
  for (const std::size_t size : components.sizes) {
    constexpr double of_a_small_one = 0.6;  // some dozen points, if it is a ball
    thinners.emplace_back(
        std::min(spacing, of_a_small_one * std::cbrt(static_cast<double>(size) * point_volume)));
  }
  SurfaceSeeds seeds;
  seeds.components = static_cast<int>(components.sizes.size());
  for_points(lattice.size, [&](int i, int j, int k) {
    const std::size_t here = lattice.index(i, j, k);
    for (int a = 0; a < 3; ++a) {
      const std::array<int, 3> next{i + (a == 0 ? 1 : 0), j + (a == 1 ? 1 : 0), k + (a == 2 ? 1 : 0)};
      if (next[static_cast<std::size_t>(a)] >= lattice.size[static_cast<std::size_t>(a)]) continue;
      const std::size_t there = lattice.index(next[0], next[1], next[2]);
      const auto from = static_cast<double>(lattice.values[here]);
      const auto to = static_cast<double>(lattice.values[there]);
      if ((from > 0.0) == (to > 0.0)) continue;
      const double fraction = from / (from - to);
      const Vec3 low = lattice.place(i, j, k);
      const Vec3 high = lattice.place(next[0], next[1], next[2]);
      const Vec3 seed{interpolate(low.x, high.x, fraction), interpolate(low.y, high.y, fraction),
                      interpolate(low.z, high.z, fraction)};
      const auto part = static_cast<std::size_t>(std::max(components.of[here], components.of[there]));
      if (thinners[part].take(seed)) seeds.points.push_back(seed);
    }
  });
  return seeds;
}

}  // namespace palpate::app
