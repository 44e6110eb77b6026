#include "overlaps.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "geometry/vector.hpp"
#include "numbers.hpp"

namespace palpate::app {

nlohmann::ordered_json overlaps_json(const Bodies& bodies, const std::vector<Overlap>& list) {
  auto json = nlohmann::ordered_json::array();
  for (const Overlap& overlap : list) {
    json.push_back(
        {{"bodies", {at(bodies.bodies(), overlap.first).name, at(bodies.bodies(), overlap.second).name}},
         {"contacts", overlap.contacts},
         {"deepest", overlap.deepest}});
  }
  return json;
}

std::string overlaps_text(const Bodies& bodies, std::vector<Overlap> list, const std::string& length_unit) {
  std::ranges::stable_sort(list, [](const Overlap& a, const Overlap& b) { return a.deepest > b.deepest; });
  constexpr std::size_t most = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(list.size(), most); ++i) {
    const Overlap& overlap = list[i];
    text += fmt::format("  {} and {}: {}, {} {} deep at most\n",
                        shown_name(at(bodies.bodies(), overlap.first).name),
                        shown_name(at(bodies.bodies(), overlap.second).name),
                        counted(overlap.contacts, "contact"), short_text(overlap.deepest), length_unit);
  }
  if (list.size() > most) text += fmt::format("  and {} more pairs that overlap less\n", list.size() - most);
  return text;
}

}  // namespace palpate::app
