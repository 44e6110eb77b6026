#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <utility>

#include "arrays.hpp"
#include "bind.hpp"
#include "docs.hpp"
#include "scene/field_values.hpp"
#include "simulation.hpp"

namespace palpate::python {
namespace {

using Three = std::array<double, 3>;
using IndicesIn = ArrayIn<Index, -1>;
using Bound = nb::class_<Simulation>;

/// Numbers as an (n) or (n x components) array that owns its memory.
nb::ndarray<nb::numpy, const double, nb::c_contig> moved_rows(std::vector<double> values, int components) {
  auto* kept = new std::vector<double>(std::move(values));
  const nb::capsule owner(kept,
                          [](void* memory) noexcept { delete static_cast<std::vector<double>*>(memory); });
  const auto columns = static_cast<std::size_t>(components);
  const std::size_t shape[2] = {kept->size() / columns, columns};
  return {kept->data(), columns == 1 ? 1U : 2U, shape, owner};
}

Vec3 vector_of_three(const Three& v) {
  return {v[0], v[1], v[2]};
}

/// Loads, springs, motions and states: checked by palpate/_simulation.py first.
void bind_changes(Bound& simulation) {
  simulation
      .def("_set_forces",
           [](Simulation& s, const IndicesIn& points, const PointsIn& forces) {
             s.idle().set_forces(values_of(points), points_of(forces));
           })
      .def("_set_pressure", [](Simulation& s, const IndicesIn& triangles,
                               double pressure) { s.idle().set_pressure(values_of(triangles), pressure); })
      .def("_set_pressures",
           [](Simulation& s, const IndicesIn& triangles, const ArrayIn<double, -1>& pressures) {
             s.idle().set_pressure(values_of(triangles), values_of(pressures));
           })
      .def("_set_positions",
           [](Simulation& s, const IndicesIn& points, const PointsIn& values) {
             s.set_positions(values_of(points), points_of(values));
           })
      .def("_set_velocities",
           [](Simulation& s, const IndicesIn& points, const PointsIn& values) {
             s.idle().set_velocities(values_of(points), points_of(values));
           })
      .def(
          "_set_motion",
          [](Simulation& s, Index number, Motion motion) { s.idle().set_motion(number, std::move(motion)); },
          nb::arg("number"), nb::arg("motion"))
      .def("_move_to",
           [](Simulation& s, Index number, const Three& translate, const std::array<double, 4>& quaternion) {
             s.idle().move_to(number, {0.0, vector_of_three(translate), quaternion});
           })
      .def("_release_body",
           [](Simulation& s, Index body) { s.change(ModelChange{.release_bodies = {body}}); })
      .def("_release_points",
           [](Simulation& s, const IndicesIn& points) {
             const auto all = values_of(points);
             s.change(ModelChange{.release_points = {all.begin(), all.end()}});
           })
      .def("_fix",
           [](Simulation& s, const IndicesIn& points) {
             const auto all = values_of(points);
             s.change(ModelChange{.fix = {all.begin(), all.end()}});
           })
      .def(
          "_move",
          [](Simulation& s, const IndicesIn& points, Motion motion) {
            const auto all = values_of(points);
            return s.move({all.begin(), all.end()}, std::move(motion));
          },
          nb::arg("points"), nb::arg("motion"))
      .def(
          "_tie",
          [](Simulation& s, const IndicesIn& points, Index to, std::optional<double> stiffness) {
            const auto all = values_of(points);
            s.tie({all.begin(), all.end()}, to, stiffness);
          },
          nb::arg("points"), nb::arg("to"), nb::arg("stiffness").none())
      .def("_untie", &Simulation::untie)
      .def("_remove", [](Simulation& s, Index body) { s.change(ModelChange{.remove = {body}}); })
      .def("_insert", [](Simulation& s, Index body) { s.change(ModelChange{.insert = {body}}); })
      .def("_is_present", [](Simulation& s, Index body) { return s.idle().is_present(body); })
      .def("_is_rigid", [](Simulation& s, Index body) { return s.idle().is_rigid(body); })
      .def("_motion_of", &Simulation::motion_of)
      .def("_motion", [](Simulation& s, Index number) { return s.idle().motion(number); })
      .def("_change", [](Simulation& s, const Scene& scene) { s.change(scene); })
      .def("_settings_text",
           [](Simulation& s, Scene scene) {
             scene.settings = s.idle().settings();
             return write_scene(scene);
           })
      .def(
          "_grab",
          [](Simulation& s, Index point, const Three& target, double stiffness) {
            return s.idle().grab({point, vector_of_three(target), stiffness});
          },
          nb::arg("point"), nb::arg("target"), nb::arg("stiffness"))
      .def("_move_grab", [](Simulation& s, Index number,
                            const Three& target) { s.idle().move_grab(number, vector_of_three(target)); })
      .def("_release", [](Simulation& s, Index number) { s.idle().release(number); })
      .def("_grab_force",
           [](Simulation& s, Index number) {
             const Vec3 force = s.idle().grab_force(number);
             return Three{force.x, force.y, force.z};
           })
      .def("_moves_freely",
           [](Simulation& s) {
             const std::span<const std::uint8_t> free = s.idle().free_points();
             return std::vector<std::uint8_t>(free.begin(), free.end());
           })
      .def("_grabs", [](Simulation& s) { return s.idle().grabs(); })
      .def(
          "_grab_of",
          [](Simulation& s, Index number) {
            const Grab& grab = s.idle().grab_of(number);
            return std::tuple(grab.point, Three{grab.target.x, grab.target.y, grab.target.z}, grab.stiffness);
          })
      .def("_prescribed_of", &Simulation::prescribed_of)
      .def("_check_prescribed", &Simulation::check_prescribed);
}

/// Binds the forces of the last step.
void bind_forces_of(Bound& simulation) {
  simulation
      .def_prop_ro(
          "acting_contacts", [](Simulation& s) { return s.acting_contacts(); },
          doc::Simulation_acting_contacts)
      .def(
          "_pair_wrenches",
          [](Simulation& s, const std::optional<Three>& about) {
            return about ? s.idle().pair_wrenches(vector_of_three(*about)) : s.idle().pair_wrenches();
          },
          nb::arg("about").none())
      .def(
          "tractions", [](Simulation& s) { return s.idle().tractions(); }, doc::Simulation_tractions)
      .def_prop_ro(
          "tie_forces", [](Simulation& s) { return copied<double>(s.idle().tie_forces()); },
          nb::rv_policy::reference, doc::Simulation_tie_forces,
          nb::sig("def tie_forces(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def("_ties",
           [](Simulation& s) {
             std::pair<std::vector<Index>, std::vector<Index>> ties;
             for (const Tie& tie : s.idle().ties()) {
               ties.first.push_back(tie.point);
               ties.second.push_back(tie.tet);
             }
             return ties;
           })
      .def("_tie_wrench",
           [](Simulation& s, Index body, const Three& about) {
             return s.idle().tie_wrench(body, vector_of_three(about));
           })
      .def("_grab_wrench",
           [](Simulation& s, Index body, const Three& about) {
             return s.idle().grab_wrench(body, vector_of_three(about));
           })
      .def(
          "record_reactions", [](Simulation& s, bool on) { s.idle().record_reactions(on); }, nb::arg("on"),
          doc::Simulation_record_reactions)
      .def_prop_ro(
          "reactions", [](Simulation& s) { return copied<double>(s.idle().reactions()); },
          nb::rv_policy::reference, doc::Simulation_reactions,
          nb::sig("def reactions(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def("_contact_wrench",
           [](Simulation& s, Index body, const Three& about) {
             return s.idle().contact_wrench(body, vector_of_three(about));
           })
      .def("_reaction_of_body",
           [](Simulation& s, Index body, const Three& about) {
             return s.idle().reaction_of_body(body, vector_of_three(about));
           })
      .def("_reaction_of_motion",
           [](Simulation& s, Index number, const Three& about) {
             return s.idle().reaction_of_motion(number, vector_of_three(about));
           })
      .def(
          "_fields",
          [](Simulation& s, const std::vector<std::string>& names) {
            nb::list list;
            const FieldArrays arrays = field_arrays(s.idle(), names);
            const auto add = [&](const FieldArray& array, bool on_points) {
              list.append(nb::make_tuple(std::string(array.info->name), on_points,
                                         unit_name(s.units(), array.info->dimension),
                                         moved_rows(array.values, array.info->components)));
            };
            for (const FieldArray& array : arrays.of_points) add(array, true);
            for (const FieldArray& array : arrays.of_tets) add(array, false);
            return list;
          },
          nb::arg("fields"),
          nb::sig("def _fields(self, fields: list[str]) -> list[tuple[str, bool, str, typing.Any]]"))
      .def(
          "_field",
          [](Simulation& s, const std::string& name, bool of_tets) {
            FieldArray field = field_array(s.idle(), name, of_tets);
            return moved_rows(std::move(field.values), field.info->components);
          },
          nb::arg("name"), nb::arg("of_tets"),
          nb::sig("def _field(self, name: str, of_tets: bool) -> numpy.typing.NDArray[numpy.float64]"))
      .def("_units",
           [](const Simulation& s) {
             return std::array{unit_name(s.units(), dimension::length),
                               unit_name(s.units(), dimension::speed)};
           })
      .def("_prescribed", [](Simulation& s) { return s.prescribed(); })
      .def("_center_of_mass",
           [](Simulation& s, Index body) {
             const Vec3 c = s.idle().center_of_mass(body);
             return Three{c.x, c.y, c.z};
           })
      .def("tissue", &Simulation::tissue, doc::Simulation_tissue)
      .def("tissue_at_points", &Simulation::tissue_at_points, nb::arg("of_tets").none() = nb::none(),
           doc::Simulation_tissue_at_points);
}

}  // namespace

void bind_drive(nb::class_<Simulation>& simulation) {
  bind_changes(simulation);
  bind_forces_of(simulation);
}

}  // namespace palpate::python
