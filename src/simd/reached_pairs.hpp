#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include <palpate/types.hpp>

namespace palpate::simd {

/// Contacts between two bodies, for edges of both.
struct ContactsOfEdges {
  const Edge* edges;
  /// Three numbers of each point: the first of its contacts, how many they are, the body of the first one.
  const Index* of_point;
  Index first;  ///< body
  Index second;
  Range points_of_first;
};

/// Pairs of an edge and a triangle of these bodies.
struct PairColumns {
  const Index* edge;
  float* apart;
  std::size_t size;
};
/// PairColumns::apart of a pair with an end in contact with the other body.
inline constexpr float apart_by_contact = std::numeric_limits<float>::infinity();

/// The pairs that are not above a limit.
struct ReachedPairs {
  static constexpr std::int32_t unsure = 1 << 30;
  std::size_t size = 0;  ///< of those without an end in contact with the other body
  float least;           ///< of those above the limit
};

/// Finds the pairs that are not above a limit. Writes the places of those without an end in contact with the
/// other body; plus `unsure` if an end has several contacts. There must be room for 16 more. The others are
/// set to `apart_by_contact`.
/// \param least  an upper bound of the result's
ReachedPairs find_reached(const PairColumns& pairs, float limit, float least, const ContactsOfEdges& contacts,
                          std::int32_t* places);

}  // namespace palpate::simd
