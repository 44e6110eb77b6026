#include <algorithm>
#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "arrays.hpp"
#include "bind.hpp"
#include "docs.hpp"
#include "geometry/vector.hpp"
#include "pickling.hpp"
#include "scene/scene.hpp"
#include "world.hpp"

namespace palpate::python {
namespace {

nb::slice slice_of(const Range& range) {
  return {range.begin, range.end, 1};
}

/// A property of all bodies as an array that keeps them alive.
template <class T, class Getter>
auto array_of(Getter getter) {
  return [getter](nb::handle_t<Bodies> self) {
    return view<T>((nb::cast<const Bodies&>(self).*getter)(), self);
  };
}

const Body& body_of_name(const Bodies& bodies, const std::string& name) {
  const auto found = std::ranges::find(bodies.bodies(), name, &Body::name);
  if (found == bodies.bodies().end()) throw nb::key_error(name.c_str());
  return *found;
}

void bind_bodies(nb::module_& m) {
  nb::class_<Body> body(m, "Body", doc::Body);
  refuse_pickling(body, "keep its name and slices");
  body.def_ro("name", &Body::name, doc::Body_name)
      .def_prop_ro(
          "points", [](const Body& b) { return slice_of(b.points); }, doc::Body_points)
      .def_prop_ro(
          "edges", [](const Body& b) { return slice_of(b.edges); }, doc::Body_edges)
      .def_prop_ro(
          "triangles", [](const Body& b) { return slice_of(b.triangles); }, doc::Body_triangles)
      .def_prop_ro(
          "tets", [](const Body& b) { return slice_of(b.tets); }, doc::Body_tets)
      .def("__repr__", [](const Body& b) {
        return "<palpate.Body '" + b.name + "': " + std::to_string(b.points.size()) + " points, " +
               std::to_string(b.tets.size()) + " tets>";
      });
  nb::class_<Bodies> all(m, "Bodies", doc::Bodies);
  refuse_pickling(all, "keep its arrays (points_rest, tets and so on)");
  all.def("__len__", &Bodies::body_count, "Number of bodies.")
      .def(
          "__getitem__",
          [](const Bodies& bodies, Index i) -> const Body& {
            if (i < 0 || i >= bodies.body_count()) throw nb::index_error("no body with this number");
            return at(bodies.bodies(), i);
          },
          nb::rv_policy::reference_internal, "A body by its number, or by its name.")
      .def("__getitem__", &body_of_name, nb::rv_policy::reference_internal)
      .def_prop_ro("points_rest", array_of<double>(&Bodies::points_rest), doc::Bodies_points_rest,
                   nb::sig("def points_rest(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro("tets", array_of<Index>(&Bodies::tets), doc::Bodies_tets,
                   nb::sig("def tets(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("edges", array_of<Index>(&Bodies::edges), doc::Bodies_edges,
                   nb::sig("def edges(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("triangles", array_of<Index>(&Bodies::triangles), doc::Bodies_triangles,
                   nb::sig("def triangles(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("body_of_point", array_of<Index>(&Bodies::body_of_point), doc::Bodies_body_of_point,
                   nb::sig("def body_of_point(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def("__repr__",
           [](const Bodies& b) { return "<palpate.Bodies: " + std::to_string(b.body_count()) + ">"; });
}

}  // namespace

void bind_world(nb::module_& m) {
  bind_bodies(m);
  nb::class_<World> bound(m, "World", doc::World);
  refuse_pickling(bound, "build it again in the other process");
  bound
      .def(
          "__init__",
          [](World* self, const Scene& scene, int threads) {
            DetectionSettings settings = scene.settings.detection;
            settings.self_collision.clear();  // set by each body
            new (self) World(settings, threads);
          },
          nb::arg("scene"), nb::arg("threads"))
      .def(
          "_add",
          [](World& world, std::string name, const PointsIn& points, const TetsIn& tets, bool movable,
             bool self_collision) {
            return world.add(std::move(name), mesh_of(points, tets), movable, self_collision);
          },
          nb::arg("name"), nb::arg("points").noconvert(), nb::arg("tets").noconvert(), nb::arg("movable"),
          nb::arg("self_collision"))
      .def("_set_ignored_pairs", &World::set_ignored_pairs, nb::arg("pairs"))
      .def(
          "_update", [](World& world, const PointsIn& positions) { world.update(points_of(positions)); },
          nb::arg("positions").noconvert())
      .def(
          "_update_again",  // bench/python_overhead.py
          [](World& world, const PointsIn& positions, int times) {
            for (int i = 0; i < times; ++i) world.update(points_of(positions));
          },
          nb::arg("positions").noconvert(), nb::arg("times"))
      .def_prop_ro(
          "bodies", [](const World& world) { return std::const_pointer_cast<Bodies>(world.bodies()); },
          doc::World_bodies)
      .def_prop_ro(
          "contacts", [](World& world) { return std::const_pointer_cast<Contacts>(world.contacts()); },
          doc::World_contacts)
      .def_prop_ro(
          "crossings", [](World& world) { return std::const_pointer_cast<Crossings>(world.crossings()); },
          doc::World_crossings)
      .def_prop_ro("edge_contacts", &World::edge_contacts, doc::World_edge_contacts)
      .def_prop_ro("stats", &World::stats, doc::World_stats)
      .def_prop_ro("times", &World::times, doc::World_times)
      .def_prop_ro(
          "late_bodies", [](const World& world) { return moved<std::uint8_t>(world.late_bodies()); },
          nb::rv_policy::reference, doc::World_late_bodies,
          nb::sig("def late_bodies(self) -> numpy.typing.NDArray[numpy.uint8]"))
      .def_prop_ro("structure_bytes", &World::structure_bytes, doc::World_structure_bytes);
  m.def(
      "renumbered",
      [](const Contacts& contacts, const ArrayIn<Index, -1>& points, const ArrayIn<Index, -1>& tets,
         const ArrayIn<Index, -1>& bodies) {
        return renumbered(contacts, values_of(points), values_of(tets), values_of(bodies));
      },
      nb::arg("contacts"), nb::arg("points"), nb::arg("tets"), nb::arg("bodies"), doc::renumbered);
}

}  // namespace palpate::python
