#pragma once

#include <algorithm>
#include <cstddef>
#include <ranges>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/contact_table.hpp"
#include "contact/local_thickness.hpp"
#include "contact/swept_query.hpp"

namespace palpate {

/// Depths, relative to the local thickness, up to which the contacts at the end of a step are enough for
/// points and for edges.
inline constexpr double deepest_point = 0.1;
inline constexpr double deepest_edge = 0.02;

/// The rows of the contacts of an edge, with all bodies. O(log(edge contacts)).
inline auto rows_of_edge(const EdgeContacts& edges, Index edge) {
  const auto [first, last] = std::ranges::equal_range(edges.edge, edge);
  return std::views::iota(static_cast<std::size_t>(first - edges.edge.begin()),
                          static_cast<std::size_t>(last - edges.edge.begin()));
}

/// How far a pair ends behind the surface that it touched within a step.
struct EndBehind {
  Vec3 back;            ///< unit vector to the side of entry at the end of the step
  double beyond = 0.0;  ///< distance behind the touch, m
  double before = 0.0;  ///< part of it that is older than the step, m: a pair may stay as deep as it was
  double thick = 0.0;   ///< local thickness, m
};

/// Tells which pairs of primitives that entered a body within a step are led back by the contacts at its end.
/// Keeps its memory from step to step.
class ExitsBack {
 public:
  ExitsBack(const Bodies& bodies, const LocalThickness& thickness) : bodies_(bodies), thickness_(thickness) {}

  /// \param contacts  at the start of the step. O(contacts log contacts).
  void begin_step(const ContactTable& contacts) { list_deep(contacts, deep_start_); }
  /// \param contacts  at the end of the step; must live as long as has_exit() is called. O(contacts log
  /// contacts).
  void set_end(const ContactTable& contacts) {
    end_ = &contacts;
    list_deep(contacts, deep_end_);
  }

  /// Whether a contact at the end of the step pushes back to the side of entry. It must be shallow, for edges
  /// even more: an edge that passes a little now starts the next step on the wrong side. O(log contacts).
  [[nodiscard]] bool has_exit(const SweptContact& contact, const EndBehind& end) const;

 private:
  /// A point that is in a body, or an end of an edge that is.
  struct PointInBody {
    Index point;
    Index body;
    friend auto operator<=>(const PointInBody&, const PointInBody&) = default;
  };
  void list_deep(const ContactTable& contacts, std::vector<PointInBody>& deep) const;
  [[nodiscard]] bool becomes_deep(const SweptContact& contact) const;
  [[nodiscard]] bool point_leads(Index point, Index body, const Vec3& back, double deepest) const;
  [[nodiscard]] bool edge_leads(Index edge, Index body, const Vec3& back, double deepest) const;

  const Bodies& bodies_;
  const LocalThickness& thickness_;
  const ContactTable* end_ = nullptr;
  std::vector<PointInBody> deep_start_;
  std::vector<PointInBody> deep_end_;
};

}  // namespace palpate
