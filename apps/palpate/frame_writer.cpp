#include "frame_writer.hpp"

#include <algorithm>

#include "geometry/vector.hpp"
#include "scene/field_values.hpp"

namespace palpate::app {

namespace {

/// Views of the arrays, for VTK's writer.
std::vector<io::NamedArray> named(const std::vector<FieldArray>& arrays, const Units& units) {
  std::vector<io::NamedArray> list;
  list.reserve(arrays.size());
  for (const FieldArray& array : arrays) {
    list.push_back({.name = std::string(array.info->name),
                    .values = std::span<const double>(array.values),
                    .components = array.info->components,
                    .unit = unit_name(units, array.info->dimension)});
  }
  return list;
}

}  // namespace

FrameWriter::FrameWriter(const std::filesystem::path& folder, const OutputSettings& output,
                         const Units& units, const FramesSoFar& so_far)
    : series_(folder, "frames", so_far.times),
      every_(output.every),
      fields_(output.fields.names),
      units_(units),
      last_step_(so_far.last_step),
      maxima_(so_far.maxima) {}

void FrameWriter::add(const Simulation& simulation, bool always) {
  const std::int64_t step = simulation.metrics().step;
  if (step == last_step_ || (!always && step % every_ != 0)) return;
  in_contact_.assign(simulation.positions().size(), 0);
  depths_.assign(simulation.positions().size(), 0.0);
  const Contacts& contacts = simulation.detector().contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    at(in_contact_, contacts.point[c]) = 1;
    double& deepest = at(depths_, contacts.point[c]);
    deepest = std::max(deepest, contacts.depth[c]);
  }
  const FieldArrays fields = field_arrays(simulation, fields_);
  const std::vector<io::NamedArray> of_points = named(fields.of_points, units_);
  const std::vector<io::NamedArray> of_tets = named(fields.of_tets, units_);
  series_.add(simulation.bodies(), {.time = simulation.metrics().time,
                                    .positions = simulation.positions(),
                                    .velocities = simulation.velocities(),
                                    .in_contact = in_contact_,
                                    .depths = depths_,
                                    .length_unit = unit_name(units_, dimension::length),
                                    .speed_unit = unit_name(units_, dimension::speed),
                                    .point_fields = of_points,
                                    .tet_fields = of_tets});
  raise_maxima(simulation, fields, maxima_);
  last_step_ = step;
}

}  // namespace palpate::app
