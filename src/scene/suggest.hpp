#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// The known name of which `word` is probably a misspelling: nearest by edits (insert, drop, replace, swap
/// neighbours; case does not count), if no more than a third of the word's letters (at least one) differ. Of
/// equals the first that begins with the same letter, else the first. The result is a view into `known`.
/// O(|known| |word| |name|).
std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> known);

/// The "expected" of an error on an unknown `word`: the nearest name in quotes, or "one of 'a', 'b'".
std::string expected_name(std::string_view word, std::span<const std::string_view> known);

}  // namespace palpate
