// Adds one to the largest int.
#include <limits>

int main(int argument_count, char**) {
  volatile int largest = std::numeric_limits<int>::max();
  largest = largest + argument_count;
  return largest == 0;
}
