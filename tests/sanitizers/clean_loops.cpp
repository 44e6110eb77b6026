// All loops of src/parallel as the library uses them, many times over: nothing to report, and the right
// result.
#include <cstddef>
#include <vector>

#include "parallel/parallel.hpp"

int main() {
  namespace parallel = palpate::parallel;
  const parallel::Threads threads(4);
  const int rounds = 50;
  std::vector<double> values(100000, 0.0);
  std::vector<double> partial;
  parallel::ChunkedList<std::size_t> chunks;
  std::vector<std::size_t> begins;
  for (int round = 1; round <= rounds; ++round) {
    parallel::for_each(threads, values.size(), 64, [&](std::size_t i) { values[i] += 1.0; });
    const double total =
        parallel::sum(threads, values.size(), partial, [&](std::size_t i) { return values[i]; });
    if (total != round * 100000.0) return 1;
    chunks.fill(
        threads, values.size(), 1000,
        [](std::size_t begin, std::size_t, std::vector<std::size_t>& list) { list.push_back(begin); });
    chunks.join(threads, begins);
    if (begins.size() != 100 || begins[99] != 99000) return 1;
  }
  return 0;
}
