// Every item of a parallel loop adds to one number.
#include "parallel/parallel.hpp"

int main() {
  long total = 0;
  palpate::parallel::for_each(palpate::parallel::Threads(4), 100000, 16, [&](std::size_t) { ++total; });
  return total < 0;
}
