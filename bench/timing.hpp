#pragma once

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>
#include <vector>

namespace palpate::bench {

/// Seconds of processor time of this thread: others who use the machine do not count but by what they take of
/// its caches.
inline double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

template <class Work>
double milliseconds(Work&& work) {
  const double start = processor_time();
  work();
  return 1e3 * (processor_time() - start);
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// What says how fast a machine is: memcpy of 64 MiB, a sort of a million floats, 20 million dependent
/// multiply-adds.
nlohmann::ordered_json machine_references();

}  // namespace palpate::bench
