#include <initializer_list>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <string>
#include <tuple>
#include <utility>

#include <palpate/error.hpp>

#include "arrays.hpp"
#include "bind.hpp"
#include "docs.hpp"
#include "material_check.hpp"
#include "model.hpp"
#include "pickling.hpp"
#include "scene/suggest.hpp"

namespace palpate::python {
namespace {

using Three = std::array<double, 3>;

Vec3 vector_of_three(const Three& v) {
  return {v[0], v[1], v[2]};
}
Three three_of(const Vec3& v) {
  return {v.x, v.y, v.z};
}

Interpolation interpolation_of(const std::string& name) {
  for (std::size_t i = 0; i < interpolation_names.size(); ++i) {
    if (interpolation_names[i] == name) return static_cast<Interpolation>(i);
  }
  throw Error("Motion", "interpolation", "'" + name + "'", expected_name(name, interpolation_names));
}

/// "palpate.Material(young_modulus=20000.0, ...)" of attributes, as Python writes them.
std::string call_text(nb::handle self, std::initializer_list<const char*> names) {
  std::string text = "palpate." + nb::cast<std::string>(self.type().attr("__name__")) + "(";
  bool first = true;
  for (const char* name : names) {
    text += (first ? "" : ", ") + std::string(name) + "=" + nb::repr(self.attr(name)).c_str();
    first = false;
  }
  return text + ")";
}

/// A value of a material that can be changed to what a scene would take.
template <class Value>
void bind_value(nb::class_<Material>& material, const char* name, Value Material::*value, const char* doc) {
  material.def_prop_rw(
      name, [value](const Material& m) { return m.*value; },
      [value](Material& m, Value given) {
        Material changed = m;
        changed.*value = given;
        check_material(changed);
        m = changed;
      },
      doc);
}

using MaterialState =
    std::tuple<double, double, double, double, double, std::optional<double>, double, std::optional<double>>;

void bind_material_values(nb::class_<Material>& material) {
  bind_value(material, "young_modulus", &Material::young_modulus, doc::Material_young_modulus);
  bind_value(material, "poisson_ratio", &Material::poisson_ratio, doc::Material_poisson_ratio);
  bind_value(material, "density", &Material::density, doc::Material_density);
  bind_value(material, "mass_damping", &Material::mass_damping, doc::Material_mass_damping);
  bind_value(material, "stiffness_damping", &Material::stiffness_damping, doc::Material_stiffness_damping);
  bind_value(material, "plastic_yield", &Material::plastic_yield, doc::Material_plastic_yield);
  bind_value(material, "plastic_creep", &Material::plastic_creep, doc::Material_plastic_creep);
  bind_value(material, "plastic_maximum", &Material::plastic_maximum, doc::Material_plastic_maximum);
  material
      .def("__repr__",
           [](nb::handle self) {
             return call_text(
                 self, {"young_modulus", "poisson_ratio", "density", "mass_damping", "stiffness_damping",
                        "plastic_yield", "plastic_creep", "plastic_maximum"});
           })
      .def("__getstate__",
           [](const Material& m) {
             return MaterialState{m.young_modulus,     m.poisson_ratio, m.density,       m.mass_damping,
                                  m.stiffness_damping, m.plastic_yield, m.plastic_creep, m.plastic_maximum};
           })
      .def("__setstate__",
           [](Material& m, const MaterialState& s) { new (&m) Material(std::make_from_tuple<Material>(s)); });
}

void bind_material(nb::module_& m) {
  const Material standard;
  nb::class_<Material> material(m, "Material", doc::Material);
  bind_material_values(material);
  material.def(
      "__init__",
      [](Material* self, double young_modulus, double poisson_ratio, double density, double mass_damping,
         double stiffness_damping, std::optional<double> plastic_yield, double plastic_creep,
         std::optional<double> plastic_maximum) {
        const Material made{young_modulus,     poisson_ratio, density,       mass_damping,
                            stiffness_damping, plastic_yield, plastic_creep, plastic_maximum};
        check_material(made);
        new (self) Material(made);
      },
      nb::kw_only(), nb::arg("young_modulus") = standard.young_modulus,
      nb::arg("poisson_ratio") = standard.poisson_ratio, nb::arg("density") = standard.density,
      nb::arg("mass_damping") = standard.mass_damping,
      nb::arg("stiffness_damping") = standard.stiffness_damping, nb::arg("plastic_yield") = nb::none(),
      nb::arg("plastic_creep") = standard.plastic_creep, nb::arg("plastic_maximum") = nb::none());
}

using KeyframeState = std::tuple<double, Three, std::array<double, 4>>;
using MotionState = std::tuple<Three, std::vector<Keyframe>, std::string>;

void bind_motion(nb::module_& m) {
  nb::class_<Ramp> ramp(m, "Ramp", doc::Ramp);
  refuse_pickling(ramp, "keep its times and factors");
  ramp.def("__repr__",
           [](const Ramp& r) { return "<palpate.Ramp: " + std::to_string(r.times.size()) + " times>"; });
  ramp.def(
          "__init__",
          [](Ramp* self, std::vector<double> times, std::vector<double> factors) {
            new (self) Ramp{std::move(times), std::move(factors)};
          },
          nb::arg("times"), nb::arg("factors"))
      .def_rw("times", &Ramp::times, doc::Ramp_times)
      .def_rw("factors", &Ramp::factors, doc::Ramp_factors);
  nb::class_<Keyframe>(m, "Keyframe", doc::Keyframe)
      .def(
          "__init__",
          [](Keyframe* self, double time, const Three& translate, const std::array<double, 4>& quaternion) {
            new (self) Keyframe{time, vector_of_three(translate), quaternion};
          },
          nb::arg("time"), nb::arg("translate") = Three{},
          nb::arg("quaternion") = std::array{1.0, 0.0, 0.0, 0.0})
      .def_rw("time", &Keyframe::time, doc::Keyframe_time)
      .def_prop_rw(
          "translate", [](const Keyframe& k) { return three_of(k.translate); },
          [](Keyframe& k, const Three& v) { k.translate = vector_of_three(v); }, doc::Keyframe_translate)
      .def_rw("quaternion", &Keyframe::quaternion, doc::Keyframe_quaternion)
      .def("__repr__",
           [](nb::handle self) {
             return call_text(self, {"time", "translate", "quaternion"});
           })
      .def("__getstate__",
           [](const Keyframe& k) {
             return KeyframeState{k.time, three_of(k.translate), k.quaternion};
           })
      .def("__setstate__", [](Keyframe& k, const KeyframeState& s) {
        new (&k) Keyframe{std::get<0>(s), vector_of_three(std::get<1>(s)), std::get<2>(s)};
      });
  nb::class_<Motion>(m, "Motion", doc::Motion)
      .def(
          "__init__",
          [](Motion* self, std::vector<Keyframe> keyframes, const Three& center,
             const std::string& interpolation) {
            new (self) Motion{vector_of_three(center), std::move(keyframes), interpolation_of(interpolation)};
          },
          nb::arg("keyframes"), nb::kw_only(), nb::arg("center") = Three{},
          nb::arg("interpolation") = "linear",
          nb::sig("def __init__(self, keyframes: typing.Sequence[Keyframe], *, center: "
                  "typing.Sequence[float] = (0.0, "
                  "0.0, 0.0), interpolation: typing.Literal['linear', 'smooth'] = 'linear') -> None"))
      .def_rw("keyframes", &Motion::keyframes, doc::Motion_keyframes)
      .def_prop_rw(
          "center", [](const Motion& o) { return three_of(o.center); },
          [](Motion& o, const Three& v) { o.center = vector_of_three(v); }, doc::Motion_center)
      .def_prop_rw(
          "interpolation",
          [](const Motion& o) {
            return std::string(interpolation_names[static_cast<std::size_t>(o.interpolation)]);
          },
          [](Motion& o, const std::string& name) { o.interpolation = interpolation_of(name); },
          doc::Motion_interpolation)
      .def("__repr__",
           [](nb::handle self) {
             return call_text(self, {"keyframes", "center", "interpolation"});
           })
      .def("__getstate__",
           [](const Motion& o) {
             return MotionState{three_of(o.center), o.keyframes,
                                std::string(interpolation_names[static_cast<std::size_t>(o.interpolation)])};
           })
      .def("__setstate__", [](Motion& o, const MotionState& s) {
        new (&o) Motion{vector_of_three(std::get<0>(s)), std::get<1>(s), interpolation_of(std::get<2>(s))};
      });
}

}  // namespace

void bind_model(nb::module_& m) {
  bind_material(m);
  bind_motion(m);
  nb::class_<Model> bound(m, "Model", doc::Model);
  refuse_pickling(bound, "make it anew there, or send the scene that it is made of");
  bound.def(nb::init<>())
      .def(
          "__init__",
          [](Model* self, const Scene& scene) {
            const nb::gil_scoped_release release;
            new (self) Model(scene);
          },
          nb::arg("scene"))
      .def(
          "_add_body",
          [](Model& model, std::string name, const PointsIn& points, const TetsIn& tets,
             std::optional<Material> material, const Three& velocity, const ArrayIn<std::uint8_t, -1>& fixed,
             bool obstacle, bool self_collision, std::optional<Motion> motion) {
            return model.add_body(mesh_of(points, tets),
                                  {std::move(name), material, vector_of_three(velocity),
                                   vector_of(values_of(fixed)), obstacle, self_collision, std::move(motion)});
          },
          nb::arg("name"), nb::arg("points"), nb::arg("tets"), nb::arg("material").none(),
          nb::arg("velocity"), nb::arg("fixed"), nb::arg("obstacle"), nb::arg("self_collision"),
          nb::arg("motion").none())
      .def("_add_region", [](Model& model, Index body, const ArrayIn<Index, -1>& tets,
                             const Material& material) { model.add_region(body, values_of(tets), material); })
      .def(
          "_attach",
          [](Model& model, Index body, const ArrayIn<Index, -1>& points, Index to,
             std::optional<double> stiffness) { model.attach(body, values_of(points), to, stiffness); },
          nb::arg("body"), nb::arg("points"), nb::arg("to"), nb::arg("stiffness").none())
      .def("_prescribe",
           [](Model& model, Index body, const ArrayIn<Index, -1>& points, Motion motion) {
             return model.prescribe(body, values_of(points), std::move(motion));
           })
      .def(
          "_load",
          [](Model& model, Index body, const ArrayIn<Index, -1>& points, const Three& force,
             std::optional<Ramp> ramp) {
            model.load(body, values_of(points), vector_of_three(force), std::move(ramp));
          },
          nb::arg("body"), nb::arg("points"), nb::arg("force"), nb::arg("ramp").none())
      .def(
          "_load_surface",
          [](Model& model, Index body, const ArrayIn<Index, -1>& points, double pressure,
             const Three& traction, const std::optional<Ramp>& ramp) {
            model.load_surface(body, values_of(points),
                               {.triangles = {},
                                .pressure = pressure,
                                .traction = vector_of_three(traction),
                                .ramp = ramp.value_or(Ramp{})});
          },
          nb::arg("body"), nb::arg("points"), nb::arg("pressure"), nb::arg("traction"),
          nb::arg("ramp").none())
      .def("_set_velocities",
           [](Model& model, Index body, const PointsIn& velocities) {
             model.set_velocities(body, points_of(velocities));
           })
      .def("_set_gravity", [](Model& model, Index body,
                              const Three& gravity) { model.set_gravity(body, vector_of_three(gravity)); })
      .def("_grab", [](Model& model, Index body, Index point, const Three& target,
                       double stiffness) { model.grab(body, point, vector_of_three(target), stiffness); })
      .def_prop_ro(
          "bodies", [](const Model& model) { return std::make_shared<Bodies>(model.data().bodies); },
          doc::Model_bodies)
      .def_prop_ro(
          "obstacles", [](const Model& model) { return model.data().obstacles; }, doc::Model_obstacles)
      .def_prop_ro("self_collision", &Model::self_collision, doc::Model_self_collision)
      .def(
          "start_positions", [](const Model& model) { return moved<double>(model.start_positions()); },
          doc::Model_start_positions,
          nb::sig("def start_positions(self) -> numpy.typing.NDArray[numpy.float64]"));
}

}  // namespace palpate::python
