#include "body_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vector>

#include "io/cell_counts.hpp"
#include "numbers.hpp"

namespace palpate::app {
namespace {

using Json = nlohmann::ordered_json;

Json spread_json(const Spread& spread) {
  return {{"min", spread.min}, {"mean", spread.mean}, {"max", spread.max}};
}

std::string spread_text(const Spread& spread) {
  return fmt::format("min {:.4g}, mean {:.4g}, max {:.4g}", spread.min, spread.mean, spread.max);
}

/// A list of numbers for people: "5, 9, 12 and 40 more".
std::string listed(const std::vector<Index>& indices) {
  constexpr std::size_t most = 10;
  const std::size_t shown = std::min(indices.size(), most);
  const std::vector<Index> head(indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(shown));
  const std::string text = fmt::format("{}", fmt::join(head, ", "));
  return indices.size() > most ? fmt::format("{} and {} more", text, indices.size() - most) : text;
}

}  // namespace

Json statistics_json(const MeshStatistics& s) {
  return {{"points", s.points},
          {"edges", s.edges},
          {"triangles", s.triangles},
          {"tets", s.tets},
          {"edge_length", spread_json(s.edge_length)},
          {"dihedral_angle", spread_json(s.dihedral_angle)},
          {"volume", s.volume},
          {"lower", to_json(s.lower)},
          {"upper", to_json(s.upper)}};
}

Json parts_json(const MeshParts& parts) {
  return {{"pieces", parts.volumes.size()},
          {"nonmanifold_edges", parts.nonmanifold_edges},
          {"nonmanifold_points", parts.nonmanifold_points}};
}

Json notes_json(const MeshRecord* file, const MeshNotes& notes) {
  Json json;
  json["file"] = file != nullptr ? Json(utf8_text(file->file)) : Json();
  json["format"] = file != nullptr ? Json(file->format) : Json();
  json["dropped"] = Json::object();
  if (file != nullptr) {
    for (const auto& [kind, count] : file->dropped) json["dropped"][utf8_text(kind)] = count;
  }
  json["dropped_solids"] = file != nullptr ? io::dropped_solids(file->dropped) : 0;
  json["converted"] = Json::object();
  if (file != nullptr) {
    for (const io::ConvertedCells& cells : file->converted)
      json["converted"][cells.kind] = {{"cells", cells.cells}, {"tets", cells.tets}};
  }
  json["reoriented_tets"] = file != nullptr ? Json(file->reoriented) : Json::array();
  json["unreferenced_points"] = notes.unreferenced_points;
  return json;
}

std::string statistics_text(const MeshStatistics& s, std::string_view length_unit) {
  const std::string unit = length_unit.empty() ? "" : fmt::format(" {}", length_unit);
  std::string text;
  text += fmt::format("points          {}\n", s.points);
  text += fmt::format("edges           {}\n", s.edges);
  text += fmt::format("triangles       {}\n", s.triangles);
  text += fmt::format("tets            {}\n", s.tets);
  text += fmt::format("edge length     {}{}\n", spread_text(s.edge_length), unit);
  text += fmt::format("dihedral angle  {} degrees\n", spread_text(s.dihedral_angle));
  text += fmt::format("volume          {:.6g}{}\n", s.volume, unit.empty() ? "" : unit + "^3");
  text += fmt::format("bounds          ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}){}\n", s.lower.x,
                      s.lower.y, s.lower.z, s.upper.x, s.upper.y, s.upper.z, unit);
  return text;
}

std::string parts_text(const MeshParts& parts) {
  std::string text = fmt::format("{}", parts.volumes.size());
  if (parts.volumes.size() > 1) {
    double sum = 0.0;
    for (const double volume : parts.volumes) sum += volume;
    text += fmt::format(", the largest with {:.3g} % of the volume", 100.0 * parts.volumes.front() / sum);
  }
  if (parts.nonmanifold_edges > 0 || parts.nonmanifold_points > 0) {
    text += fmt::format("; {} and {} where the surface is no manifold",
                        counted(static_cast<std::size_t>(parts.nonmanifold_edges), "edge"),
                        counted(static_cast<std::size_t>(parts.nonmanifold_points), "point"));
  }
  return text;
}

std::string notes_text(const MeshRecord* file, const MeshNotes& notes) {
  std::vector<std::string> parts;
  if (file != nullptr && !file->dropped.empty()) {
    std::vector<std::string> kinds;
    kinds.reserve(file->dropped.size());
    for (const auto& [kind, count] : file->dropped) kinds.push_back(fmt::format("{} {}", count, kind));
    parts.push_back(fmt::format("cells left out: {}", fmt::join(kinds, ", ")));
    if (const Index solids = io::dropped_solids(file->dropped); solids > 0) {
      parts.push_back("volume is missing: that of " +
                      counted(static_cast<std::size_t>(solids), "solid cell"));
    }
  }
  if (file != nullptr) {
    for (const io::ConvertedCells& cells : file->converted) {
      parts.push_back(cells.tets == cells.cells
                          ? fmt::format("{} {} cells taken as linear tets", cells.cells, cells.kind)
                          : fmt::format("{} {} cells cut into {} tets", cells.cells, cells.kind, cells.tets));
    }
  }
  if (file != nullptr && !file->reoriented.empty()) {
    parts.push_back(fmt::format("{} re-oriented: {}", counted(file->reoriented.size(), "inverted tet"),
                                listed(file->reoriented)));
  }
  if (notes.unreferenced_points > 0) {
    parts.push_back(counted(static_cast<std::size_t>(notes.unreferenced_points), "point") + " in no tet");
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace palpate::app
