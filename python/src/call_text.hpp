#pragma once

#include <array>
#include <initializer_list>
#include <nanobind/nanobind.h>
#include <string>

#include <palpate/types.hpp>

namespace palpate::python {

namespace nb = nanobind;

using Three = std::array<double, 3>;

inline Vec3 vector_of_three(const Three& v) {
  return {v[0], v[1], v[2]};
}
inline Three three_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

/// "palpate.Material(young_modulus=20000.0, ...)" of attributes, as Python writes them.
inline std::string call_text(nb::handle self, std::initializer_list<const char*> names) {
  std::string text = "palpate." + nb::cast<std::string>(self.type().attr("__name__")) + "(";
  bool first = true;
  for (const char* name : names) {
    text += (first ? "" : ", ") + std::string(name) + "=" + nb::repr(self.attr(name)).c_str();
    first = false;
  }
  return text + ")";
}

}  // namespace palpate::python
