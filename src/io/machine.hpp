#pragma once

#include <istream>
#include <string>

namespace palpate::io {

/// Machine and build of a run, to compare it with others.
struct Machine {
  std::string cpu;         ///< model name as the system gives it, "unknown" where it gives none
  int cores = 0;           ///< hardware threads that this process may use
  std::string compiler;    ///< "GNU 12.2.0"
  std::string build_type;  ///< "Release", "Debug", ...; followed by the sanitizers, if any
  std::string commit;  ///< git commit (40 hex digits, "-dirty" after them if sources differed), or "unknown"
};

/// The machine and build of this process. Reads /proc/cpuinfo; never throws where it is missing.
Machine describe_machine();

/// The first "model name" in text of the form of /proc/cpuinfo, or "unknown".
std::string cpu_model(std::istream& cpuinfo);

}  // namespace palpate::io
