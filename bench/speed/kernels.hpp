#pragma once

#include <array>
#include <string_view>

namespace palpate::bench {

/// A kernel whose instructions are counted, and its unit of work.
struct Kernel {
  std::string_view name;
  std::string_view unit;
  int frames_for_one = 1;  ///< frames asked for, for each that is counted: more where counting takes minutes
};

inline constexpr std::array<Kernel, 12> kernels{{{"point query, full rebuild", "tet"},
                                                 {"point query, coherent", "tet"},
                                                 {"crossings", "border edge"},
                                                 {"depth", "contact"},
                                                 {"whole detection", "tet"},
                                                 {"step of the falling stack", "tet", 2},
                                                 {"element pass", "tet"},
                                                 {"element pass, neo-Hookean", "tet"},
                                                 {"assembly", "tet"},
                                                 {"product with the matrix", "point"},
                                                 {"conjugate gradients", "point and iteration"},
                                                 {"factor solve", "point"}}};

}  // namespace palpate::bench
