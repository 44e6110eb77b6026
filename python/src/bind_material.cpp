#include <algorithm>
#include <cstdint>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/material.hpp>
#include <palpate/tissues.hpp>

#include "bind.hpp"
#include "call_text.hpp"
#include "docs.hpp"
#include "material_check.hpp"
#include "pickling.hpp"
#include "scene/suggest.hpp"

namespace palpate::python {
namespace {

/// A number that is not True or False, which Python takes for 1 and 0.
struct Number {
  double value = 0.0;
  operator double() const { return value; }  // NOLINT(google-explicit-constructor)
};

/// The name of a value of an enumeration, as a Literal type for type checkers; a test compares the names with
/// the schema.
template <class Kind>
struct NameOf {
  std::string text;
};
using ModelName = NameOf<MaterialModel>;
using ElementName = NameOf<ElementKind>;
using TissueName = NameOf<Tissue>;

template <class Kind>
constexpr auto literal = nb::detail::const_name("str");
template <>
constexpr auto literal<MaterialModel> =
    nb::detail::const_name("typing.Literal['corotational', 'stable-neo-hookean', 'mooney-rivlin']");
template <>
constexpr auto literal<ElementKind> = nb::detail::const_name("typing.Literal['linear', 'smoothed']");
template <>
constexpr auto literal<Tissue> = nb::detail::const_name(
    "typing.Literal['liver', 'kidney', 'spleen', 'brain', 'fat', 'muscle', 'skin', 'sclera', 'tendon', "
    "'cartilage', 'trabecular-bone', 'cortical-bone']");

}  // namespace
}  // namespace palpate::python

namespace nanobind::detail {
template <>
struct type_caster<palpate::python::Number> {
  NB_TYPE_CASTER(palpate::python::Number, const_name("float"))
  bool from_python(handle source, std::uint8_t flags, cleanup_list* cleanup) noexcept {
    make_caster<double> number;
    if (is_truth(source.ptr()) || !number.from_python(source, flags, cleanup)) return false;
    value.value = number.value;
    return true;
  }
  static handle from_cpp(const palpate::python::Number& number, rv_policy policy,
                         cleanup_list* cleanup) noexcept {
    return make_caster<double>::from_cpp(number.value, policy, cleanup);
  }

 private:
  /// Whether it is a bool of Python or NumPy (bool_ before NumPy 2). The stable ABI hides tp_name.
  static bool is_truth(PyObject* source) noexcept {
    if (PyBool_Check(source)) return true;
    PyObject* const name = PyObject_GetAttrString(reinterpret_cast<PyObject*>(Py_TYPE(source)), "__name__");
    if (name == nullptr) {
      PyErr_Clear();
      return false;
    }
    const bool same = PyUnicode_CompareWithASCIIString(name, "bool_") == 0 ||
                      PyUnicode_CompareWithASCIIString(name, "bool") == 0;
    Py_DECREF(name);
    return same;
  }
};
template <class Kind>
struct type_caster<palpate::python::NameOf<Kind>> {
  NB_TYPE_CASTER(palpate::python::NameOf<Kind>, palpate::python::literal<Kind>)
  bool from_python(handle source, std::uint8_t flags, cleanup_list* cleanup) noexcept {
    make_caster<std::string> text;
    if (!text.from_python(source, flags, cleanup)) return false;
    value.text = std::move(text.value);
    return true;
  }
  static handle from_cpp(const palpate::python::NameOf<Kind>& name, rv_policy policy,
                         cleanup_list* cleanup) noexcept {
    return make_caster<std::string>::from_cpp(name.text, policy, cleanup);
  }
};
}  // namespace nanobind::detail

namespace palpate::python {
namespace {

/// A value of a material, with a setter that accepts the same values as a scene. `Given` is double or
/// optional, with Number instead of double.
template <class Given, class Value>
void bind_value(nb::class_<Material>& material, const char* name, Value Material::*value, const char* doc) {
  material.def_prop_rw(
      name, [value](const Material& m) { return m.*value; },
      [value](Material& m, Given given) {
        Material changed = m;
        changed.*value = Value(given);
        check_material(changed);
        m = changed;
      },
      doc);
}

using FibresState = std::tuple<Three, double, double, double, std::vector<double>, std::vector<double>>;
using ViscosityState = std::tuple<std::vector<double>, std::vector<double>>;
using MaterialState =
    std::tuple<double, double, double, double, double, std::optional<double>, double, std::optional<double>,
               std::string, double, std::string, FibresState, ViscosityState>;

FibresState state_of(const Fibres& f) {
  return {three_of(f.direction), f.stiffness,        f.exponent,
          f.active_stress,       f.activation.times, f.activation.factors};
}

Fibres fibres_of(const FibresState& s) {
  return {vector_of_three(std::get<0>(s)),
          std::get<1>(s),
          std::get<2>(s),
          std::get<3>(s),
          {std::get<4>(s), std::get<5>(s)}};
}

Viscosity viscosity_of(const ViscosityState& s) {
  return {std::get<0>(s), std::get<1>(s)};
}

template <class Kind>
constexpr std::span<const std::string_view> names_of;
template <>
constexpr std::span<const std::string_view> names_of<MaterialModel> = material_model_names;
template <>
constexpr std::span<const std::string_view> names_of<ElementKind> = element_kind_names;
template <>
constexpr std::span<const std::string_view> names_of<Tissue> = tissue_names;

template <class Kind>
NameOf<Kind> name_of(Kind kind) {
  return {std::string(names_of<Kind>[static_cast<std::size_t>(kind)])};
}

/// \param key  key of Material, for the message
template <class Kind>
Kind kind_of(const NameOf<Kind>& name, const char* key) {
  const auto found = std::ranges::find(names_of<Kind>, name.text);
  if (found != names_of<Kind>.end()) return static_cast<Kind>(found - names_of<Kind>.begin());
  throw Error("Material", key, "'" + name.text + "'", expected_name(name.text, names_of<Kind>));
}

/// Binds a member of Material that is an enumeration as a Python property that holds its name.
template <class Kind>
void bind_kind(nb::class_<Material>& material, const char* key, Kind Material::*kind, const char* doc) {
  material.def_prop_rw(
      key, [kind](const Material& m) { return name_of(m.*kind); },
      [key, kind](Material& m, const NameOf<Kind>& name) {
        Material changed = m;
        changed.*kind = kind_of(name, key);
        check_material(changed);
        m = changed;
      },
      doc);
}

MaterialState state_of(const Material& m) {
  return {m.young_modulus,
          m.poisson_ratio,
          m.density,
          m.mass_damping,
          m.stiffness_damping,
          m.plastic_yield,
          m.plastic_creep,
          m.plastic_maximum,
          name_of(m.model).text,
          m.mooney_fraction,
          name_of(m.elements).text,
          state_of(m.fibres),
          {m.viscosity.fractions, m.viscosity.times}};
}

Material material_of(const MaterialState& s) {
  return {.young_modulus = std::get<0>(s),
          .poisson_ratio = std::get<1>(s),
          .density = std::get<2>(s),
          .mass_damping = std::get<3>(s),
          .stiffness_damping = std::get<4>(s),
          .plastic_yield = std::get<5>(s),
          .plastic_creep = std::get<6>(s),
          .plastic_maximum = std::get<7>(s),
          .model = kind_of(ModelName{std::get<8>(s)}, "model"),
          .mooney_fraction = std::get<9>(s),
          .elements = kind_of(ElementName{std::get<10>(s)}, "elements"),
          .fibres = fibres_of(std::get<11>(s)),
          .viscosity = viscosity_of(std::get<12>(s))};
}

void bind_fibre_class(nb::module_& m) {
  const Fibres standard;
  nb::class_<Fibres> fibres(m, "Fibres", doc::Fibres);
  fibres
      .def(
          "__init__",
          [](Fibres* self, const Three& direction, Number stiffness, Number exponent, Number active_stress,
             const std::optional<Ramp>& activation) {
            Fibres made{vector_of_three(direction), stiffness, exponent, active_stress,
                        activation.value_or(Ramp{})};
            check_material({.model = MaterialModel::stable_neo_hookean, .fibres = made});
            new (self) Fibres(std::move(made));
          },
          nb::kw_only(), nb::arg("direction") = three_of(standard.direction),
          nb::arg("stiffness") = standard.stiffness, nb::arg("exponent") = standard.exponent,
          nb::arg("active_stress") = standard.active_stress, nb::arg("activation") = nb::none())
      .def_prop_ro(
          "direction", [](const Fibres& f) { return three_of(f.direction); }, doc::Fibres_direction)
      .def_ro("stiffness", &Fibres::stiffness, doc::Fibres_stiffness)
      .def_ro("exponent", &Fibres::exponent, doc::Fibres_exponent)
      .def_ro("active_stress", &Fibres::active_stress, doc::Fibres_active_stress)
      .def_prop_ro(
          "activation",
          [](const Fibres& f) {
            return f.activation.times.empty() ? std::nullopt : std::optional(f.activation);
          },
          doc::Fibres_activation)
      .def("__repr__", [](nb::handle self) {
        return call_text(self, {"direction", "stiffness", "exponent", "active_stress", "activation"});
      });
  pickle_and_compare(
      fibres, [](const Fibres& f) { return state_of(f); }, fibres_of);
}

void bind_viscosity_class(nb::module_& m) {
  nb::class_<Viscosity> viscosity(m, "Viscosity", doc::Viscosity);
  viscosity
      .def(
          "__init__",
          [](Viscosity* self, std::vector<double> fractions, std::vector<double> times) {
            Viscosity made{std::move(fractions), std::move(times)};
            check_material({.viscosity = made});
            new (self) Viscosity(std::move(made));
          },
          nb::kw_only(), nb::arg("fractions"), nb::arg("times"))
      .def_ro("fractions", &Viscosity::fractions, doc::Viscosity_fractions)
      .def_ro("times", &Viscosity::times, doc::Viscosity_times)
      .def("__repr__", [](nb::handle self) {
        return call_text(self, {"fractions", "times"});
      });
  pickle_and_compare(
      viscosity,
      [](const Viscosity& v) {
        return ViscosityState{v.fractions, v.times};
      },
      viscosity_of);
}

void bind_material_values(nb::class_<Material>& material) {
  bind_value<Number>(material, "young_modulus", &Material::young_modulus, doc::Material_young_modulus);
  bind_value<Number>(material, "poisson_ratio", &Material::poisson_ratio, doc::Material_poisson_ratio);
  bind_value<Number>(material, "density", &Material::density, doc::Material_density);
  bind_value<Number>(material, "mass_damping", &Material::mass_damping, doc::Material_mass_damping);
  bind_value<Number>(material, "stiffness_damping", &Material::stiffness_damping,
                     doc::Material_stiffness_damping);
  bind_value<std::optional<Number>>(material, "plastic_yield", &Material::plastic_yield,
                                    doc::Material_plastic_yield);
  bind_value<Number>(material, "plastic_creep", &Material::plastic_creep, doc::Material_plastic_creep);
  bind_value<std::optional<Number>>(material, "plastic_maximum", &Material::plastic_maximum,
                                    doc::Material_plastic_maximum);
  bind_kind(material, "model", &Material::model, doc::Material_model);
  bind_kind(material, "elements", &Material::elements, doc::Material_elements);
  bind_value<Number>(material, "mooney_fraction", &Material::mooney_fraction, doc::Material_mooney_fraction);
  material
      .def_prop_rw(
          "fibres", [](const Material& m) { return m.fibres.any() ? std::optional(m.fibres) : std::nullopt; },
          [](Material& m, std::optional<Fibres> fibres) {
            Material changed = m;
            changed.fibres = std::move(fibres).value_or(Fibres{});
            check_material(changed);
            m = std::move(changed);
          },
          nb::arg("fibres").none(), doc::Material_fibres)
      .def_prop_rw(
          "viscosity",
          [](const Material& m) { return m.viscosity.any() ? std::optional(m.viscosity) : std::nullopt; },
          [](Material& m, std::optional<Viscosity> viscosity) {
            Material changed = m;
            changed.viscosity = std::move(viscosity).value_or(Viscosity{});
            check_material(changed);
            m = std::move(changed);
          },
          nb::arg("viscosity").none(), doc::Material_viscosity)
      .def("__repr__", [](nb::handle self) {
        return call_text(self, {"young_modulus", "poisson_ratio", "density", "mass_damping",
                                "stiffness_damping", "plastic_yield", "plastic_creep", "plastic_maximum",
                                "model", "mooney_fraction", "elements", "fibres", "viscosity"});
      });
  pickle_and_compare(
      material, [](const Material& m) { return state_of(m); }, material_of);
}

}  // namespace

void bind_material(nb::module_& m) {
  bind_fibre_class(m);
  bind_viscosity_class(m);
  const Material standard;
  nb::class_<Material> material(m, "Material", doc::Material);
  bind_material_values(material);
  material.def_static(
      "tissue", [](const TissueName& name) { return tissue_material(kind_of(name, "tissue")); },
      nb::arg("name"), doc::tissue_material);
  material.def(
      "__init__",
      [](Material* self, Number young_modulus, Number poisson_ratio, Number density, Number mass_damping,
         Number stiffness_damping, std::optional<Number> plastic_yield, Number plastic_creep,
         std::optional<Number> plastic_maximum, const ModelName& model, Number mooney_fraction,
         const ElementName& elements, std::optional<Fibres> fibres, std::optional<Viscosity> viscosity) {
        const Material made{young_modulus,
                            poisson_ratio,
                            density,
                            mass_damping,
                            stiffness_damping,
                            plastic_yield,
                            plastic_creep,
                            plastic_maximum,
                            kind_of(model, "model"),
                            mooney_fraction,
                            kind_of(elements, "elements"),
                            std::move(fibres).value_or(Fibres{}),
                            std::move(viscosity).value_or(Viscosity{})};
        check_material(made);
        new (self) Material(made);
      },
      nb::kw_only(), nb::arg("young_modulus") = standard.young_modulus,
      nb::arg("poisson_ratio") = standard.poisson_ratio, nb::arg("density") = standard.density,
      nb::arg("mass_damping") = standard.mass_damping,
      nb::arg("stiffness_damping") = standard.stiffness_damping, nb::arg("plastic_yield") = nb::none(),
      nb::arg("plastic_creep") = standard.plastic_creep, nb::arg("plastic_maximum") = nb::none(),
      nb::arg("model") = name_of(standard.model), nb::arg("mooney_fraction") = standard.mooney_fraction,
      nb::arg("elements") = name_of(standard.elements), nb::arg("fibres") = nb::none(),
      nb::arg("viscosity") = nb::none());
}

}  // namespace palpate::python
