#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <string>

#include <palpate/detection.hpp>

#include "arrays.hpp"
#include "bind.hpp"
#include "crossings.hpp"
#include "docs.hpp"
#include "fields.hpp"

namespace palpate::python {
namespace {

void bind_contacts(nb::module_& m) {
  const auto column = [](auto member) {
    return [member](nb::handle_t<Contacts> self) {
      return view<Index>(nb::cast<const Contacts&>(self).*member, self);
    };
  };
  nb::class_<Contacts> contacts(m, "Contacts", doc::Contacts);
  refuse_pickling(contacts, "keep its arrays (point, tet, depth and so on)");
  contacts
      .def_prop_ro("point", column(&Contacts::point), doc::Contacts_point,
                   nb::sig("def point(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("body", column(&Contacts::body), doc::Contacts_body,
                   nb::sig("def body(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("tet", column(&Contacts::tet), doc::Contacts_tet,
                   nb::sig("def tet(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro(
          "weights",
          [](nb::handle_t<Contacts> self) {
            return view<double>(nb::cast<const Contacts&>(self).weights, self);
          },
          doc::Contacts_weights, nb::sig("def weights(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "depth",
          [](nb::handle_t<Contacts> self) {
            return view<double>(nb::cast<const Contacts&>(self).depth, self);
          },
          doc::Contacts_depth, nb::sig("def depth(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "direction",
          [](nb::handle_t<Contacts> self) {
            return view<double>(nb::cast<const Contacts&>(self).direction, self);
          },
          doc::Contacts_direction, nb::sig("def direction(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "certainty",
          [](nb::handle_t<Contacts> self) {
            return view<double>(nb::cast<const Contacts&>(self).certainty, self);
          },
          doc::Contacts_certainty, nb::sig("def certainty(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def(
          "to_dataframe",
          [](nb::handle self) { return nb::module_::import_("palpate._view").attr("contacts_frame")(self); },
          nb::sig("def to_dataframe(self) -> typing.Any"),
          "A pandas DataFrame with a row for each contact, vectors in columns _x, _y, _z. Needs pandas.")
      .def("__len__", &Contacts::size, "Number of contacts.")
      .def("__repr__",
           [](const Contacts& c) { return "<palpate.Contacts: " + std::to_string(c.size()) + ">"; });
}

void bind_crossings(nb::module_& m) {
  const auto column = [](auto member) {
    return [member](nb::handle_t<Crossings> self) {
      return view<Index>(nb::cast<const Crossings&>(self).*member, self);
    };
  };
  nb::class_<Crossings> crossings(m, "Crossings", doc::Crossings);
  refuse_pickling(crossings, "keep its arrays (contact, free_point and so on)");
  crossings
      .def_prop_ro("contact", column(&Crossings::contact), doc::Crossings_contact,
                   nb::sig("def contact(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("free_point", column(&Crossings::free_point), doc::Crossings_free_point,
                   nb::sig("def free_point(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro("triangle", column(&Crossings::triangle), doc::Crossings_triangle,
                   nb::sig("def triangle(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro(
          "parameter",
          [](nb::handle_t<Crossings> self) {
            return view<double>(nb::cast<const Crossings&>(self).parameter, self);
          },
          doc::Crossings_parameter, nb::sig("def parameter(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def(
          "__len__", [](const Crossings& c) { return c.contact.size(); }, "Number of crossings.")
      .def("__repr__", [](const Crossings& c) {
        return "<palpate.Crossings: " + std::to_string(c.contact.size()) + ">";
      });
}

void bind_edge_contacts(nb::module_& m) {
  nb::class_<EdgeContacts> edges(m, "EdgeContacts", doc::EdgeContacts);
  refuse_pickling(edges, "keep its arrays (edge, body and so on)");
  edges
      .def_prop_ro(
          "edge",
          [](nb::handle_t<EdgeContacts> self) {
            return view<Index>(nb::cast<const EdgeContacts&>(self).edge, self);
          },
          doc::EdgeContacts_edge, nb::sig("def edge(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro(
          "body",
          [](nb::handle_t<EdgeContacts> self) {
            return view<Index>(nb::cast<const EdgeContacts&>(self).body, self);
          },
          doc::EdgeContacts_body, nb::sig("def body(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro(
          "triangles",
          [](nb::handle_t<EdgeContacts> self) {
            return view<Index>(nb::cast<const EdgeContacts&>(self).triangles, self);
          },
          doc::EdgeContacts_triangles, nb::sig("def triangles(self) -> numpy.typing.NDArray[numpy.int32]"))
      .def_prop_ro(
          "parameters",
          [](nb::handle_t<EdgeContacts> self) {
            return view<double>(nb::cast<const EdgeContacts&>(self).parameters, self);
          },
          doc::EdgeContacts_parameters,
          nb::sig("def parameters(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "depth",
          [](nb::handle_t<EdgeContacts> self) {
            return view<double>(nb::cast<const EdgeContacts&>(self).depth, self);
          },
          doc::EdgeContacts_depth, nb::sig("def depth(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "direction",
          [](nb::handle_t<EdgeContacts> self) {
            return view<double>(nb::cast<const EdgeContacts&>(self).direction, self);
          },
          doc::EdgeContacts_direction, nb::sig("def direction(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def("__len__", &EdgeContacts::size, "Number of edge contacts.")
      .def("__repr__",
           [](const EdgeContacts& c) { return "<palpate.EdgeContacts: " + std::to_string(c.size()) + ">"; });
}

void bind_counts(nb::module_& m) {
  nb::class_<DetectionCounts> counts(m, "DetectionCounts", doc::DetectionCounts);
  using Counts = DetectionCounts;
  Fields<Counts>(counts)
      .add("contacts", &Counts::contacts, doc::DetectionCounts_contacts)
      .add("edge_contacts", &Counts::edge_contacts, doc::DetectionCounts_edge_contacts)
      .add("unseen_pairs", &Counts::unseen_pairs, doc::DetectionCounts_unseen_pairs)
      .add("border_edges", &Counts::border_edges, doc::DetectionCounts_border_edges)
      .add("crossings", &Counts::crossings, doc::DetectionCounts_crossings)
      .add("candidates", &Counts::candidates, doc::DetectionCounts_candidates)
      .add("movers", &Counts::movers, doc::DetectionCounts_movers)
      .add("folded_pairs", &Counts::folded_pairs, doc::DetectionCounts_folded_pairs)
      .add("depth_fallbacks", &Counts::depth_fallbacks, doc::DepthCounts_depth_fallbacks)
      .add("cancelled_directions", &Counts::cancelled_directions, doc::DepthCounts_cancelled_directions)
      .add("raised_depths", &Counts::raised_depths, doc::DepthCounts_raised_depths)
      .add("regions_without_border", &Counts::regions_without_border, doc::DepthCounts_regions_without_border)
      .add("border_edges_without_crossing", &Counts::border_edges_without_crossing,
           doc::DepthCounts_border_edges_without_crossing)
      .add("approximated_primitives", &Counts::approximated_primitives,
           doc::DetectionCounts_approximated_primitives)
      .add("dropped_cells", &Counts::dropped_cells, doc::DetectionCounts_dropped_cells)
      .add("rough_depths", &Counts::rough_depths, doc::DepthCounts_rough_depths)
      .add("late_clusters", &Counts::late_clusters, doc::DetectionCounts_late_clusters)
      .add("completeness", &Counts::completeness, doc::DetectionCounts_late_clusters)
      .add("cells", &Counts::cells, doc::DetectionCounts_cells)
      .add("cell_size", &Counts::cell_size, doc::DetectionCounts_cell_size)
      .get(
          "sort",
          [](const Counts& c) -> std::optional<std::string> {
            if (!c.sort) return std::nullopt;
            return std::string(sort_names[static_cast<std::size_t>(*c.sort)]);
          },
          doc::DetectionCounts_sort);
  nb::class_<DetectionTimes> times(m, "DetectionTimes", doc::DetectionTimes);
  Fields<DetectionTimes>(times)
      .add("grid", &DetectionTimes::grid, doc::DetectionTimes_grid)
      .add("contacts", &DetectionTimes::contacts, doc::DetectionTimes_contacts)
      .add("border_edges", &DetectionTimes::border_edges, doc::DetectionTimes_border_edges)
      .add("crossings", &DetectionTimes::crossings, doc::DetectionTimes_crossings)
      .add("depth", &DetectionTimes::depth, doc::DetectionTimes_depth);
}

}  // namespace

void bind_detection(nb::module_& m) {
  bind_contacts(m);
  bind_crossings(m);
  bind_edge_contacts(m);
  bind_counts(m);
}

}  // namespace palpate::python
