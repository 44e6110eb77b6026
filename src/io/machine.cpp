#include "io/machine.hpp"

#include <algorithm>
#include <fstream>
#include <thread>

namespace palpate::io {

extern const char* const source_commit;  // defined in the generated machine_commit.cpp

std::string cpu_model(std::istream& cpuinfo) {
  for (std::string line; std::getline(cpuinfo, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    if (begin == std::string::npos) continue;
    return line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin);
  }
  return "unknown";
}

Machine describe_machine() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  return {.cpu = cpu_model(cpuinfo),
          .cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency())),
          .compiler = PALPATE_COMPILER,
          .build_type = PALPATE_BUILD_TYPE,
          .commit = source_commit};
}

}  // namespace palpate::io
