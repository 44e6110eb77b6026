#include "measure/report.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <stdexcept>

#include "io/atomic_file.hpp"
#include "io/machine.hpp"
#include "scene/json_text.hpp"
#include "stopwatch.hpp"

namespace palpate::measure {

using Json = nlohmann::ordered_json;

std::vector<int> thread_counts() {
  const int most = std::max(1, io::describe_machine().cores);
  std::vector<int> counts;
  for (int n = 1; n <= most; n *= 2) counts.push_back(n);
  if (counts.back() != most) counts.push_back(most);
  return counts;
}

Json report_of(std::string_view kind, std::string_view effort) {
  const io::Machine machine = io::describe_machine();
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return {{"kind", kind},
          {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(now))},
          {"machine",
           {{"cpu", machine.cpu},
            {"cores", machine.cores},
            {"compiler", machine.compiler},
            {"build_type", machine.build_type},
            {"commit", machine.commit}}},
          {"effort", effort},
          {"complete", false},
          {"load", 0.0},
          {"sections", Json::array()}};
}

void measure_items(Json& report, const std::vector<Item>& items, const std::filesystem::path& file,
                   const std::function<void(const std::string& line)>& tell,
                   const std::function<bool()>& interrupted) {
  io::create_folder(file.parent_path());
  Stopwatch watch;
  for (std::size_t i = 0; i < items.size(); ++i) {
    Section section;
    try {
      if (interrupted()) throw Interrupted{};
      section = items[i].measure();
    } catch (const Interrupted&) {
      throw std::runtime_error(
          "interrupted; " + (i == 0 ? "nothing was written"
                                    : fmt::format("{} has {} of {} items", file.string(), i, items.size())));
    }
    report["sections"].push_back(to_json(section));
    report["complete"] = i + 1 == items.size();
    const std::string verdict = section.paper.empty()
                                    ? "done"
                                    : std::string(verdict_names[static_cast<std::size_t>(section.verdict)]);
    std::array<double, 1> load{};
    if (getloadavg(load.data(), 1) == 1) report["load"] = std::max(load[0], report.value("load", 0.0));
    io::write_atomically(file, format_json(report) + "\n");
    tell(fmt::format("{} of {}: {}: {}, {:.1f} s", i + 1, items.size(), section.title, verdict, watch.lap()));
  }
}

}  // namespace palpate::measure
