#include <exception>
#include <nanobind/nanobind.h>

#include <palpate/error.hpp>
#include <palpate/version.hpp>

#include "bind.hpp"
#include "parallel/threads.hpp"
#include "wrong_arguments.hpp"

namespace palpate::python {
namespace {

/// palpate::Error as the Python class of that name, with its four parts.
void translate_error(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    const nanobind::object type = nanobind::module_::import_("palpate._error").attr("Error");
    const nanobind::object made =
        type(error.source().c_str(), error.where().c_str(), error.found().c_str(), error.expected().c_str());
    PyErr_SetObject(type.ptr(), made.ptr());
  }
}

}  // namespace
}  // namespace palpate::python

NB_MODULE(_core, m) {
  using namespace palpate::python;
  m.doc() = "The compiled part of palpate: what palpate's own modules are made of.";
  // Objects that are alive when the interpreter ends belong to variables of the program and are no leaks.
  nanobind::set_leak_warnings(false);
  nanobind::register_exception_translator(translate_error);
  m.attr("version") = PALPATE_VERSION;
  m.attr("most_threads") = palpate::parallel::Threads::most;
  bind_detection(m);
  bind_world(m);
  bind_scene(m);
  bind_model(m);
  bind_forces(m);
  bind_simulation(m);
  report_wrong_arguments(m);
}
