#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace palpate {

/// The known name of which `word` is probably a misspelling: the nearest by edits (insert, delete, replace,
/// swap neighbours; case is ignored), if at most a third of the word's letters (at least one) differ. If
/// several are equally near, the first that begins with the same letter, otherwise the first. The result is a
/// view into `known`. O(|known| |word| |name|).
std::optional<std::string_view> nearest_name(std::string_view word, std::span<const std::string_view> known);

/// The text for "expected" in an error about an unknown `word`: the nearest name in quotes, or "one of 'a',
/// 'b'".
std::string expected_name(std::string_view word, std::span<const std::string_view> known);

}  // namespace palpate
