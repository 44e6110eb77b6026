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
#include "call_text.hpp"
#include "docs.hpp"
#include "model.hpp"
#include "pickling.hpp"
#include "scene/suggest.hpp"

namespace palpate::python {
namespace {

Interpolation interpolation_of(const std::string& name) {
  for (std::size_t i = 0; i < interpolation_names.size(); ++i) {
    if (interpolation_names[i] == name) return static_cast<Interpolation>(i);
  }
  throw Error("Motion", "interpolation", "'" + name + "'", expected_name(name, interpolation_names));
}

using RampState = std::tuple<std::vector<double>, std::vector<double>>;
using KeyframeState = std::tuple<double, Three, std::array<double, 4>>;
using MotionState = std::tuple<Three, std::vector<KeyframeState>, std::string>;

KeyframeState state_of(const Keyframe& k) {
  return {k.time, three_of(k.translate), k.quaternion};
}

Keyframe keyframe_of(const KeyframeState& s) {
  return {std::get<0>(s), vector_of_three(std::get<1>(s)), std::get<2>(s)};
}

MotionState state_of(const Motion& o) {
  std::vector<KeyframeState> keyframes;
  keyframes.reserve(o.keyframes.size());
  for (const Keyframe& keyframe : o.keyframes) keyframes.push_back(state_of(keyframe));
  return {three_of(o.center), std::move(keyframes),
          std::string(interpolation_names[static_cast<std::size_t>(o.interpolation)])};
}

Motion motion_of(const MotionState& s) {
  std::vector<Keyframe> keyframes;
  keyframes.reserve(std::get<1>(s).size());
  for (const KeyframeState& keyframe : std::get<1>(s)) keyframes.push_back(keyframe_of(keyframe));
  return {vector_of_three(std::get<0>(s)), std::move(keyframes), interpolation_of(std::get<2>(s))};
}

void bind_motion(nb::module_& m) {
  nb::class_<Ramp> ramp(m, "Ramp", doc::Ramp);
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
  pickle_and_compare(
      ramp,
      [](const Ramp& r) {
        return RampState{r.times, r.factors};
      },
      [](const RampState& s) {
        return Ramp{std::get<0>(s), std::get<1>(s)};
      });
  nb::class_<Keyframe> keyframe(m, "Keyframe", doc::Keyframe);
  keyframe
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
      .def("__repr__", [](nb::handle self) {
        return call_text(self, {"time", "translate", "quaternion"});
      });
  pickle_and_compare(
      keyframe, [](const Keyframe& k) { return state_of(k); }, keyframe_of);
  nb::class_<Motion> motion(m, "Motion", doc::Motion);
  motion
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
      .def("__repr__", [](nb::handle self) {
        return call_text(self, {"keyframes", "center", "interpolation"});
      });
  pickle_and_compare(
      motion, [](const Motion& o) { return state_of(o); }, motion_of);
}

}  // namespace

void bind_model(nb::module_& m) {
  bind_motion(m);
  bind_material(m);
  nb::class_<Model> bound(m, "Model", doc::Model);
  refuse_pickling(bound, "build it again there, or send the scene that it is made of");
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
                                  {std::move(name), std::move(material), vector_of_three(velocity),
                                   vector_of(values_of(fixed)), obstacle, self_collision, std::move(motion)});
          },
          nb::arg("name"), nb::arg("points"), nb::arg("tets"), nb::arg("material").none(),
          nb::arg("velocity"), nb::arg("fixed"), nb::arg("obstacle"), nb::arg("self_collision"),
          nb::arg("motion").none())
      .def("_is_rigid", &Model::is_rigid)
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
      .def("_set_fibres", [](Model& model, Index body,
                             const PointsIn& directions) { model.set_fibres(body, points_of(directions)); })
      .def("_set_fibres_between",
           [](Model& model, Index body, const ArrayIn<Index, -1>& start, const ArrayIn<Index, -1>& end) {
             model.set_fibres_between(body, values_of(start), values_of(end));
           })
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
