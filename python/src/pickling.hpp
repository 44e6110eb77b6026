#pragma once

#include <nanobind/nanobind.h>
#include <string>

namespace palpate::python {

namespace nb = nanobind;

/// Makes pickle and copy refuse a class (and derived classes) with a one-line message on what to do instead.
template <class T>
void refuse_pickling(nb::class_<T>& bound, const char* instead) {
  bound.def(
      "__reduce__",
      [instead](nb::handle self) -> nb::object {
        const std::string name = nb::cast<std::string>(self.type().attr("__name__"));
        throw nb::type_error(("a palpate." + name + " cannot be pickled or copied: " + instead).c_str());
      },
      nb::sig("def __reduce__(self) -> typing.NoReturn"), "Refuses: it stays in its process.");
}

}  // namespace palpate::python
