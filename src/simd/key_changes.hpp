#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::simd {

/// Lists where `now` differs from `before`: first + i for each i with before[i] != now[i], ascending. Returns
/// their number.
/// \param before,now  of the same size
/// \param changed     room for as many as `before` has; all of it may be overwritten
std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed);

namespace scalar {
/// The twin of simd::list_changes in plain C++.
std::size_t list_changes(std::span<const std::uint32_t> before, std::span<const std::uint32_t> now,
                         std::uint32_t first, std::uint32_t* changed);
}  // namespace scalar

}  // namespace palpate::simd
