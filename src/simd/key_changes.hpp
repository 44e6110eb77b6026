#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::simd {

/// Lists first + i for each i with before[i] != now[i], ascending. Returns their number.
/// \param before,now  spans of the same size
/// \param changed     of the size of `before`; all of it may be overwritten
std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed);

namespace scalar {
/// simd::list_changes in plain C++.
std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed);
}  // namespace scalar

}  // namespace palpate::simd
