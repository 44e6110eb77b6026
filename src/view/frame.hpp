#pragma once

#include <string>

#include "view/source.hpp"

namespace palpate::view {

/// The message with the data that do not change: bodies, triangles, rest positions. Sent once to each page.
std::string stage_message(const Source& source, const Surface& surface);

/// The state of a source: surface positions (float32, relative to the origin), and the data that `look` asks
/// for. `header` has other data for the page. Time and length O(vertices + requested data).
std::string frame_message(const Source& source, const Surface& surface, const DisplayOptions& display,
                          nlohmann::ordered_json header);

}  // namespace palpate::view
