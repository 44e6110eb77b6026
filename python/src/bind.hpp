#pragma once

#include <nanobind/nanobind.h>

/// The bindings, one function per file. The texts of `doc` are generated from the C++ comments.
namespace palpate::python {

class Simulation;

void bind_detection(nanobind::module_& m);
void bind_world(nanobind::module_& m);
void bind_material(nanobind::module_& m);
void bind_model(nanobind::module_& m);
void bind_forces(nanobind::module_& m);
void bind_drive(nanobind::class_<Simulation>& simulation);
void bind_simulation(nanobind::module_& m);
void bind_scene(nanobind::module_& m);

}  // namespace palpate::python
