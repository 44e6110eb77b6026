#pragma once

#include <vector>

#include "domain_mesher.hpp"
#include "tissue_lines.hpp"

namespace palpate::app {

/// Divides lines into edges of about these sizes, and puts balls round their ends: those of neighbours on a
/// line overlap, others do not. Where lines are too near to each other for that, they are left out, the
/// shorter ones first, so that no small tets are needed there. O(n log n).
std::vector<LineBall> line_balls(const TissueLines& lines, const SizeField& size);

}  // namespace palpate::app
