#include "measure/sort_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "sort/word.hpp"

namespace palpate::measure {
namespace {

class Cube {
 public:
  explicit Cube(std::size_t cells)
      : side_(static_cast<std::uint32_t>(std::ceil(std::cbrt(static_cast<double>(cells))))) {}
  [[nodiscard]] std::uint32_t cells() const { return side_ * side_ * side_; }
  /// A cell beside `key` within the domain.
  std::uint32_t beside(std::uint32_t key, std::mt19937_64& random) const {
    std::array<std::uint32_t, 3> cell{key % side_, key / side_ % side_, key / (side_ * side_)};
    const std::uint64_t draw = random();
    std::uint32_t& coordinate = cell.at(draw % 3);
    const bool up = coordinate == 0 || ((draw >> 32 & 1) != 0 && coordinate + 1 < side_);
    coordinate += up ? 1U : 0xFFFFFFFFU;
    return cell[0] + side_ * (cell[1] + side_ * cell[2]);
  }

 private:
  std::uint32_t side_;
};

double fraction_of(Movers movers) {
  constexpr std::array fractions{0.0, 0.02, 0.1, 0.5, 1.0, 1.0};
  return fractions.at(static_cast<std::size_t>(movers));
}

}  // namespace

std::string name_of(Movers movers) {
  constexpr std::array names{"0", "2_near", "10_near", "50_near", "100_near", "100_random"};
  return names.at(static_cast<std::size_t>(movers));
}

std::size_t SortFrames::frame_at(std::size_t step) const {
  const std::size_t place = step % steps();
  return place < keys.size() ? place : steps() - place;
}

SortFrames make_frames(std::size_t entries, Movers movers) {
  const Cube cube(entries);
  std::mt19937_64 random(entries);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  SortFrames frames;
  frames.key_count = cube.cells();
  const std::size_t count = entries > 5000000 ? 6 : 41;
  std::vector<std::uint32_t> keys(entries);
  for (auto& key : keys) key = static_cast<std::uint32_t>(random() % cube.cells());
  for (std::size_t frame = 0; frame < count; ++frame) {
    frames.keys.push_back(keys);
    std::vector<std::uint64_t>& sorted = frames.sorted.emplace_back(entries);
    for (std::size_t i = 0; i < entries; ++i) sorted[i] = make_word(keys[i], static_cast<std::uint32_t>(i));
    std::sort(sorted.begin(), sorted.end());
    for (auto& key : keys) {
      if (uniform(random) >= fraction_of(movers)) continue;
      key = movers == Movers::random_100 ? static_cast<std::uint32_t>(random() % cube.cells())
                                         : cube.beside(key, random);
    }
  }
  return frames;
}

}  // namespace palpate::measure
