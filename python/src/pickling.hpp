#pragma once

#include <nanobind/nanobind.h>
#include <string>
#include <type_traits>

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

/// Makes a class picklable by its state, a tuple, and equal to others of the same state. Its objects can be
/// changed, so they have no hash. `state_of` and `from_state` are free functions or lambdas without captures.
template <class T, class StateOf, class FromState>
void pickle_and_compare(nb::class_<T>& bound, StateOf state_of, FromState from_state) {
  using State = std::invoke_result_t<StateOf, const T&>;
  bound.def("__getstate__", state_of)
      .def("__setstate__", [from_state](T& self, const State& state) { new (&self) T(from_state(state)); })
      .def(
          "__eq__",
          [state_of](const T& self, nb::handle other) -> nb::object {
            if (!nb::isinstance<T>(other)) return nb::borrow(Py_NotImplemented);
            return nb::bool_(state_of(self) == state_of(nb::cast<const T&>(other)));
          },
          nb::arg("other").none(), nb::sig("def __eq__(self, other: object, /) -> bool"),
          "Whether all values are equal.")
      .def(
          "__hash__",
          [](nb::handle self) -> nb::object {
            const std::string name = nb::cast<std::string>(self.type().attr("__name__"));
            throw nb::type_error(("unhashable type: a palpate." + name + " can change").c_str());
          },
          nb::sig("def __hash__(self) -> typing.NoReturn"), "Refuses: its values can change.");
}

}  // namespace palpate::python
