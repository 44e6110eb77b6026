#pragma once

#include <optional>

#include <palpate/settings.hpp>

#include "contact/allowance.hpp"

namespace palpate {

/// How much work a query may do, and the region whose clusters come first (docs/budget.md).
struct WorkLimit {
  Allowance& allowance;
  const std::optional<InterestRegion>& region;
};

}  // namespace palpate
