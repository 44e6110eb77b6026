#include "speed/part.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fmt/format.h>

#include "io/atomic_file.hpp"
#include "scene/json_text.hpp"
#include "stopwatch.hpp"

namespace palpate::bench {

Json run_part(const Part& part, Json head, const std::filesystem::path& file,
              const std::function<void(const std::string& line)>& tell) {
  head["part"] = part.name;
  head["load"] = 0.0;
  head["table"] = Json::array();
  head["cases"] = Json::array();
  Stopwatch watch;
  for (std::size_t i = 0; i < part.cases.size(); ++i) {
    head["cases"].push_back(part.cases[i].measure());
    head["table"] = part.rows(head["cases"]);
    std::array<double, 1> load{};
    if (getloadavg(load.data(), 1) == 1) head["load"] = std::max(load[0], head.value("load", 0.0));
    io::write_atomically(file, format_json(head) + "\n");
    tell(fmt::format("{}, {} of {}: {}, {:.1f} s", part.name, i + 1, part.cases.size(), part.cases[i].name,
                     watch.lap()));
  }
  return head;
}

}  // namespace palpate::bench
