#pragma once

#include <palpate/types.hpp>

namespace palpate {

/// A point lies in a tet of another body, or of its own.
struct PointInTet {
  Index point;
  Index tet;
};

}  // namespace palpate
