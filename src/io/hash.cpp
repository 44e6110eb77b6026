#include "io/hash.hpp"

#include <bit>
#include <cstddef>

namespace palpate::io {

static_assert(std::endian::native == std::endian::little, "hashes are of little-endian bytes");

std::uint64_t fnv1a(std::span<const std::byte> bytes, std::uint64_t hash) {
  for (const std::byte byte : bytes) {
    hash ^= static_cast<std::uint64_t>(byte);
    hash *= 0x100000001b3U;
  }
  return hash;
}

std::string state_hash(std::span<const Vec3> positions, std::span<const Vec3> velocities) {
  std::uint64_t hash = fnv1a(std::as_bytes(velocities), fnv1a(std::as_bytes(positions)));
  std::string digits(16, '0');
  for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit, hash >>= 4U) {
    *digit = "0123456789abcdef"[hash & 0xfU];
  }
  return digits;
}

}  // namespace palpate::io
