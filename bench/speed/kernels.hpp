#pragma once

#include <array>
#include <string_view>

namespace palpate::bench {

/// A kernel whose instructions are counted, and its unit of work.
struct Kernel {
  std::string_view name;
  std::string_view unit;
};

inline constexpr std::array<Kernel, 10> kernels{{{"point query, full rebuild", "tet"},
                                                 {"point query, coherent", "tet"},
                                                 {"crossings", "border edge"},
                                                 {"depth", "contact"},
                                                 {"whole detection", "tet"},
                                                 {"element pass", "tet"},
                                                 {"assembly", "tet"},
                                                 {"product with the matrix", "point"},
                                                 {"conjugate gradients", "point and iteration"},
                                                 {"factor solve", "point"}}};

}  // namespace palpate::bench
