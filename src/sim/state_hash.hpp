#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include <palpate/types.hpp>

namespace palpate {

/// FNV-1a, 64 bits, of bytes; `hash` continues an earlier one. (Fowler, Noll, Vo: offset basis and prime of
/// 64 bits.)
std::uint64_t fnv1a(std::span<const std::byte> bytes, std::uint64_t hash = 0xcbf29ce484222325U);

/// Identifies the state of a simulation: FNV-1a (64 bits) of the bytes of all positions (n_points x 3) and
/// then all velocities (n_points x 3), little-endian float64, as 16 hex digits. Equal states give equal
/// hashes. States that differ in any bit (also the sign of a zero) have equal hashes with a probability of
/// about 2^-64. O(n).
std::string state_hash(std::span<const Vec3> positions, std::span<const Vec3> velocities);

}  // namespace palpate
