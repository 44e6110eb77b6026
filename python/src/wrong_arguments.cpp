#include "wrong_arguments.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <nanobind/stl/string.h>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

namespace palpate::python {
namespace {

namespace nb = nanobind;

/// How nanobind calls a function: a few methods for all functions, by the number and kind of arguments.
using Call = PyObject* (*)(PyObject*, PyObject* const*, std::size_t, PyObject*);
std::array<Call, 12> methods{};

/// Names of properties, by the functions that set them: nanobind does not tell these.
std::unordered_map<const PyObject*, std::string>& properties() {
  static std::unordered_map<const PyObject*, std::string> names;
  return names;
}

/// Replaces nanobind's error for arguments that fit no signature; leaves all others.
void replace_error(const PyObject* function, PyObject* const* args, std::size_t flagged_count,
                   PyObject* keywords) noexcept {
  if (PyErr_ExceptionMatches(PyExc_TypeError) == 0) return;
  nb::python_error raised;
  try {
    const std::string text = nb::cast<std::string>(nb::str(raised.value()));
    if (text.find("(): incompatible function arguments") == std::string::npos) return raised.restore();
    constexpr std::size_t count_bits = 0xffff;  // above them are flags
    const std::size_t count = flagged_count & count_bits;
    nb::list positional;
    for (std::size_t i = 0; i < count; ++i) positional.append(nb::handle(args[i]));
    nb::dict named;
    if (keywords != nullptr) {
      for (std::size_t i = 0; i < nb::len(nb::handle(keywords)); ++i)
        named[nb::handle(keywords)[i]] = nb::handle(args[count + i]);
    }
    const auto property = properties().find(function);
    const nb::object error =
        nb::module_::import_("palpate._error")
            .attr("wrong_arguments")(text, positional, named,
                                     property == properties().end() ? "" : property->second);
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
  } catch (...) {
    raised.restore();
  }
}

template <std::size_t method>
PyObject* call(PyObject* function, PyObject* const* args, std::size_t count, PyObject* keywords) {
  PyObject* const result = methods[method](function, args, count, keywords);
  if (result == nullptr) replace_error(function, args, count, keywords);
  return result;
}

template <std::size_t... method>
constexpr std::array<Call, sizeof...(method)> calls_of(std::index_sequence<method...>) {
  return {&call<method>...};
}
constexpr auto calls = calls_of(std::make_index_sequence<std::tuple_size_v<decltype(methods)>>());

/// Where a function of nanobind keeps its Call.
std::ptrdiff_t place_of_call([[maybe_unused]] nb::handle function) {
#if defined(Py_LIMITED_API)
  return sizeof(PyVarObject);  // the stable ABI does not tell; nanobind has it first
#else
  return Py_TYPE(function.ptr())->tp_vectorcall_offset;
#endif
}

void redirect(nb::handle function) {
  const std::string type = nb::cast<std::string>(function.type().attr("__name__"));
  if (type != "nb_func" && type != "nb_method") return;
  char* const place = reinterpret_cast<char*>(function.ptr()) + place_of_call(function);
  Call present = nullptr;
  std::memcpy(&present, place, sizeof present);
  if (std::ranges::find(calls, present) != calls.end()) return;  // by another name before
  auto* method = std::ranges::find(methods, present);
  if (method == methods.end()) {
    method = std::ranges::find(methods, nullptr);
    if (method == methods.end())
      throw std::logic_error("nanobind calls functions in more methods than palpate knows");
    *method = present;
  }
  std::memcpy(place, &calls[static_cast<std::size_t>(method - methods.begin())], sizeof present);
}

void redirect_all(nb::handle names) {
  for (const nb::handle item : names.attr("items")()) {
    const nb::object value = item[1];
    if (PyType_Check(value.ptr()) != 0) {
      if (nb::type_check(value)) redirect_all(value.attr("__dict__"));
    } else if (!nb::hasattr(value, "fset")) {
      redirect(value);
    } else if (!value.attr("fset").is_none()) {
      redirect(value.attr("fset"));
      properties()[value.attr("fset").ptr()] = nb::cast<std::string>(item[0]);
    }
  }
}

}  // namespace

void report_wrong_arguments(nb::module_& m) {
  redirect_all(m.attr("__dict__"));
}

}  // namespace palpate::python
