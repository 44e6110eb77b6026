#pragma once

#include <nanobind/nanobind.h>

namespace palpate::python {

/// Lets calls of all functions of a module with arguments of a wrong type raise one line, as palpate.Error
/// has it, instead of nanobind's list of signatures. Call it when the module is complete. It costs one call
/// more.
void report_wrong_arguments(nanobind::module_& m);

}  // namespace palpate::python
