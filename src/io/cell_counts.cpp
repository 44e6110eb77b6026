#include "io/cell_counts.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

std::string counted(std::string_view kind, Index count) {
  if (count == 1) return fmt::format("1 {}", kind);
  if (std::isdigit(static_cast<unsigned char>(kind.back())) != 0)
    return fmt::format("{} {} cells", count, kind);
  if (kind == "vertex") return fmt::format("{} vertices", count);
  if (kind.ends_with("hedron")) return fmt::format("{} {}a", count, kind.substr(0, kind.size() - 2));
  return fmt::format("{} {}s", count, kind);
}

}  // namespace

void count_dropped(MeshFile& file, std::string_view kind, Index count) {
  if (count == 0) return;
  auto& dropped = file.dropped;
  const auto known =
      std::find_if(dropped.begin(), dropped.end(), [&](const auto& entry) { return entry.first == kind; });
  if (known == dropped.end()) {
    dropped.emplace_back(kind, count);
  } else {
    known->second += count;
  }
}

Index dropped_solids(const std::vector<std::pair<std::string, Index>>& dropped) {
  Index solids = 0;
  for (const auto& [kind, count] : dropped) {
    if (kind == "polyhedron" || kind == "convex point set") solids += count;
  }
  return solids;
}

void require_tets(const MeshFile& file, const std::string& source) {
  if (file.mesh.points.empty()) throw Error(source, "", "no points", "at least four points");
  if (!file.mesh.tets.empty()) return;
  std::string found;
  for (const auto& [kind, count] : file.dropped) {
    found += (found.empty() ? "" : ", ") + counted(kind, count);
  }
  throw Error(source, "", found.empty() ? "no cells" : found + " and no tet", "at least one tet");
}

}  // namespace palpate::io
