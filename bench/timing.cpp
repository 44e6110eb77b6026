#include "timing.hpp"

#include <cstdint>

namespace palpate::bench {

nlohmann::ordered_json machine_references() {
  const std::vector<char> from(std::size_t{64} << 20, 1);
  std::vector<char> to(from.size());
  std::vector<double> copies;
  for (int i = 0; i < 9; ++i)
    copies.push_back(milliseconds([&] { std::copy(from.begin(), from.end(), to.begin()); }));
  std::vector<double> sorts;
  for (int i = 0; i < 5; ++i) {
    std::vector<float> values(1000000);
    std::uint32_t state = 1;
    for (float& value : values) value = static_cast<float>((state = state * 1664525U + 1013904223U) >> 8U);
    sorts.push_back(milliseconds([&] { std::sort(values.begin(), values.end()); }));
  }
  std::vector<double> chains;
  volatile double result = 0.0;
  for (int i = 0; i < 5; ++i) {
    chains.push_back(milliseconds([&] {
      double x = result;
      for (int k = 0; k < 20000000; ++k) x = x * 0.999999 + 1e-6;
      result = x;
    }));
  }
  return {{"memcpy_GB_per_s", static_cast<double>(from.size()) / median(copies) * 1e-6},
          {"sort_ms", median(sorts)},
          {"multiply_add_ms", median(chains)}};
}

}  // namespace palpate::bench
