#include "overlaps.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <span>

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

std::string unseen_pairs_text(std::size_t pairs) {
  return fmt::format(
      "no contact      in {} of bodies that cross edge on edge: contact.edge_contacts is false",
      counted(pairs, "pair"));
}

nlohmann::ordered_json coarse_pairs_json(const Bodies& bodies, const std::vector<CoarsePair>& list) {
  auto json = nlohmann::ordered_json::array();
  for (const CoarsePair& pair : list) {
    json.push_back(
        {{"bodies", {at(bodies.bodies(), pair.bodies[0]).name, at(bodies.bodies(), pair.bodies[1]).name}},
         {"edges", pair.edges},
         {"thickness", pair.thickness}});
  }
  return json;
}

std::string coarse_pairs_text(const Bodies& bodies, const std::vector<CoarsePair>& list,
                              const std::string& length_unit) {
  constexpr std::size_t most = 5;
  std::string text;
  for (const CoarsePair& pair : std::span(list).first(std::min(list.size(), most))) {
    const auto body = [&](std::size_t i) {
      return fmt::format("{} (edges of {} {}, {} {} thin)",
                         shown_name(at(bodies.bodies(), pair.bodies[i]).name), short_text(pair.edges[i]),
                         length_unit, short_text(pair.thickness[i]), length_unit);
    };
    text += fmt::format("too coarse      {} and {}, for each other\n", body(0), body(1));
  }
  if (list.size() > most) text += fmt::format("                and {} more pairs\n", list.size() - most);
  return text;
}

}  // namespace palpate::app
