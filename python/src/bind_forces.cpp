#include <nanobind/stl/array.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <palpate/forces.hpp>
#include <palpate/tissue.hpp>

#include "arrays.hpp"
#include "bind.hpp"
#include "docs.hpp"
#include "pickling.hpp"
#include "simulation.hpp"

namespace palpate::python {
namespace {

using Three = std::array<double, 3>;

/// An array over the rows of a vector, of any shape beyond the first axis; `owner` keeps the memory.
template <class T, class Row>
nb::ndarray<nb::numpy, const T, nb::c_contig> rows_of(const std::vector<Row>& rows,
                                                      std::initializer_list<std::size_t> shape,
                                                      nb::handle owner) {
  std::vector<std::size_t> whole{rows.size()};
  whole.insert(whole.end(), shape.begin(), shape.end());
  return {reinterpret_cast<const T*>(rows.data()), whole.size(), whole.data(), owner};
}

/// Adds a property for a column of a structure of arrays.
template <class Struct, class T = double>
class Columns {
 public:
  explicit Columns(nb::class_<Struct>& bound) : bound_(bound) {}
  template <class Row>
  Columns& add(const char* name, std::vector<Row> Struct::*member, std::initializer_list<std::size_t> shape,
               const char* doc) {
    const std::vector<std::size_t> kept(shape);
    bound_.def_prop_ro(
        name,
        [member, kept](nb::handle_t<Struct> self) {
          const std::vector<Row>& rows = nb::cast<const Struct&>(self).*member;
          std::vector<std::size_t> whole{rows.size()};
          whole.insert(whole.end(), kept.begin(), kept.end());
          return nb::ndarray<nb::numpy, const T, nb::c_contig>(reinterpret_cast<const T*>(rows.data()),
                                                               whole.size(), whole.data(), self);
        },
        doc, nb::sig(signature(name).c_str()));
    return *this;
  }

 private:
  static std::string signature(const char* name) {
    const char* const kind = std::is_same_v<T, double>  ? "float64"
                             : std::is_same_v<T, Index> ? "int32"
                                                        : "uint8";
    return std::string("def ") + name + "(self) -> numpy.typing.NDArray[numpy." + kind + "]";
  }
  nb::class_<Struct>& bound_;
};

/// Symmetric tensors as 3x3 matrices.
nb::ndarray<nb::numpy, const double, nb::c_contig> matrices_of(const std::vector<SymmetricTensor>& tensors) {
  std::vector<Tensor> rows;
  rows.reserve(tensors.size());
  for (const SymmetricTensor& t : tensors)
    rows.push_back({t.xx, t.xy, t.xz, t.xy, t.yy, t.yz, t.xz, t.yz, t.zz});
  auto* kept = new std::vector<Tensor>(std::move(rows));
  const nb::capsule owner(kept,
                          [](void* memory) noexcept { delete static_cast<std::vector<Tensor>*>(memory); });
  return rows_of<double>(*kept, {3, 3}, owner);
}

void bind_wrench(nb::module_& m) {
  nb::class_<Wrench> wrench(m, "Wrench", doc::Wrench);
  refuse_pickling(wrench, "keep its force, torque and about");
  wrench
      .def_prop_ro(
          "force", [](const Wrench& w) { return copied<double>(std::span<const double>(&w.force.x, 3)); },
          nb::rv_policy::reference, doc::Wrench_force,
          nb::sig("def force(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "torque", [](const Wrench& w) { return copied<double>(std::span<const double>(&w.torque.x, 3)); },
          nb::rv_policy::reference, doc::Wrench_torque,
          nb::sig("def torque(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "about", [](const Wrench& w) { return copied<double>(std::span<const double>(&w.about.x, 3)); },
          nb::rv_policy::reference, doc::Wrench_about,
          nb::sig("def about(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def(
          "moved_to",
          [](const Wrench& w, const Three& about) {
            return moved_to(w, {about[0], about[1], about[2]});
          },
          nb::arg("about"), doc::moved_to)
      .def("__repr__", [](const Wrench& w) {
        const auto numbers = [](const Vec3& v) { return nb::make_tuple(v.x, v.y, v.z); };
        return nb::cast<std::string>(
            nb::str("<palpate.Wrench: force {}, torque {} about {}>")
                .attr("format")(numbers(w.force), numbers(w.torque), numbers(w.about)));
      });
  nb::class_<PairWrench> pair(m, "PairWrench", doc::PairWrench);
  refuse_pickling(pair, "keep its bodies, its normal force and the arrays of on_b");
  pair.def_ro("body_a", &PairWrench::body_a, doc::PairWrench_body_a)
      .def_ro("body_b", &PairWrench::body_b, doc::PairWrench_body_b)
      .def_ro("contacts", &PairWrench::contacts, doc::PairWrench_contacts)
      .def_ro("normal", &PairWrench::normal, doc::PairWrench_normal)
      .def_ro("on_b", &PairWrench::on_b, doc::PairWrench_on_b)
      .def("__repr__", [](const PairWrench& w) {
        return "<palpate.PairWrench: bodies " + std::to_string(w.body_a) + " and " +
               std::to_string(w.body_b) + ", " + std::to_string(w.contacts) + " contacts>";
      });
}

void bind_contact_forces(nb::module_& m) {
  nb::class_<ContactForces> forces(m, "ContactForces", doc::ContactForces);
  refuse_pickling(forces, "keep its arrays, or what to_dataframe() returns");
  Columns<ContactForces, Index>(forces)
      .add("point", &ContactForces::point, {}, doc::ContactForces_point)
      .add("edge", &ContactForces::edge, {}, doc::ContactForces_edge)
      .add("body", &ContactForces::body, {}, doc::ContactForces_body)
      .add("tet", &ContactForces::tet, {}, doc::ContactForces_tet);
  Columns<ContactForces>(forces)
      .add("weights", &ContactForces::weights, {4}, doc::ContactForces_weights)
      .add("depth", &ContactForces::depth, {}, doc::ContactForces_depth)
      .add("direction", &ContactForces::direction, {3}, doc::ContactForces_direction)
      .add("normal", &ContactForces::normal, {}, doc::ContactForces_normal)
      .add("friction", &ContactForces::friction, {3}, doc::ContactForces_friction);
  Columns<ContactForces, std::uint8_t>(forces).add("speculative", &ContactForces::speculative, {},
                                                   doc::ContactForces_speculative);
  forces
      .def_prop_ro(
          "force",
          [](const ContactForces& c) {
            std::vector<Vec3> all;
            for (std::size_t i = 0; i < c.size(); ++i) all.push_back(c.force(i));
            return moved<double>(std::move(all));
          },
          nb::rv_policy::reference, "(n x 3) whole force on each point, N.",
          nb::sig("def force(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "status",
          [](const ContactForces& c) {
            std::vector<std::string> names;
            names.reserve(c.status.size());
            for (const ContactStatus status : c.status)
              names.emplace_back(contact_status_names[static_cast<std::size_t>(status)]);
            return names;
          },
          "(n) \"open\" (separated), \"stick\" or \"slide\".")
      .def(
          "to_dataframe",
          [](nb::handle self) {
            return nb::module_::import_("palpate._view").attr("contact_forces_frame")(self);
          },
          nb::sig("def to_dataframe(self) -> typing.Any"),
          "A row for each contact, vectors in columns _x, _y, _z. Needs pandas.")
      .def("__len__", &ContactForces::size, "Number of contacts.")
      .def("__repr__", [](const ContactForces& c) {
        return "<palpate.ContactForces: " + std::to_string(c.size()) + " contacts>";
      });
}

void bind_tractions(nb::module_& m) {
  nb::class_<SurfaceTractions> surface(m, "SurfaceTractions", doc::SurfaceTractions);
  refuse_pickling(surface, "keep its arrays");
  surface.def("__repr__", [](const SurfaceTractions& s) {
    return "<palpate.SurfaceTractions: " + std::to_string(s.area.size()) + " triangles>";
  });
  using S = SurfaceTractions;
  Columns<S>(surface)
      .add("corner_forces", &S::corner_forces, {3, 3}, doc::SurfaceTractions_corner_forces)
      .add("area", &S::area, {}, doc::SurfaceTractions_area)
      .add("traction", &S::traction, {3}, doc::SurfaceTractions_traction)
      .add("pressure", &S::pressure, {}, doc::SurfaceTractions_pressure)
      .add("point_forces", &S::point_forces, {3}, doc::SurfaceTractions_point_forces)
      .add("point_traction", &S::point_traction, {3}, doc::SurfaceTractions_point_traction)
      .add("point_pressure", &S::point_pressure, {}, doc::SurfaceTractions_point_pressure);
}

void bind_tissue(nb::module_& m) {
  nb::class_<TissueState> tissue(m, "TissueState", doc::TissueState);
  refuse_pickling(tissue, "keep its arrays");
  tissue.def("__repr__", [](const TissueState& s) {
    return "<palpate.TissueState: " + std::to_string(s.size()) + " rows>";
  });
  using S = TissueState;
  Columns<S>(tissue)
      .add("deformation_gradient", &S::deformation_gradient, {3, 3}, doc::TissueState_deformation_gradient)
      .add("von_mises", &S::von_mises, {}, doc::TissueState_von_mises)
      .add("pressure", &S::pressure, {}, doc::TissueState_pressure)
      .add("principal_stress", &S::principal_stress, {3}, doc::TissueState_principal_stress)
      .add("principal_directions", &S::principal_directions, {3, 3}, doc::TissueState_principal_directions)
      .add("energy_density", &S::energy_density, {}, doc::TissueState_energy_density)
      .add("volume_ratio", &S::volume_ratio, {}, doc::TissueState_volume_ratio);
  const auto tensors = [&](const char* name, auto member, const char* doc) {
    const std::string signature =
        std::string("def ") + name + "(self) -> numpy.typing.NDArray[numpy.float64]";
    tissue.def_prop_ro(
        name, [member](const S& s) { return matrices_of(s.*member); }, nb::rv_policy::reference, doc,
        nb::sig(signature.c_str()));
  };
  tensors("strain", &S::strain, "(n x 3 x 3) Green's strain: (F^T F - I) / 2.");
  tensors("stress", &S::stress, "(n x 3 x 3) Cauchy's stress, Pa; tension is positive.");
  tensors("plastic_strain", &S::plastic_strain, "(n x 3 x 3) in the corotated frame of the tet.");
  tissue.def("__len__", &S::size, "Number of rows.");
}

}  // namespace

void bind_forces(nb::module_& m) {
  bind_wrench(m);
  bind_contact_forces(m);
  bind_tractions(m);
  bind_tissue(m);
}

}  // namespace palpate::python
