// Reads one element past the end.
#include <vector>

int main(int argument_count, char**) {
  const std::vector<int> values(static_cast<std::size_t>(argument_count) + 7, 1);
  const int* volatile first = values.data();
  return first[values.size()];
}
