#include "field_maxima.hpp"

#include <algorithm>

#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

/// Updates a maximum by the largest value of a frame.
class Raise {
 public:
  Raise(const Simulation& simulation, bool of_tets) : simulation_(simulation), of_tets_(of_tets) {}

  void operator()(const FieldArray& field, FieldMaximum& most) const {
    const std::vector<double> values = row_sizes(field.values, field.info->components);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] > most.value || (most.step < 0 && values[i] == values[i])) take(values[i], i, most);
    }
  }

 private:
  void take(double value, std::size_t row, FieldMaximum& most) const {
    const Bodies& bodies = simulation_.bodies();
    const Index item = static_cast<Index>(row);
    const Index body = of_tets_ ? bodies.body_of(at(bodies.tets(), item)) : at(bodies.body_of_point(), item);
    const Body& its = at(bodies.bodies(), body);
    most.value = value;
    most.step = simulation_.metrics().step;
    most.body = body;
    most.item = item - (of_tets_ ? its.tets.begin : its.points.begin);
    most.of_tets = of_tets_;
    most.place = {};
    if (!of_tets_) {
      most.place = at(simulation_.positions(), item);
      return;
    }
    for (const Index p : at(bodies.tets(), item)) most.place += 0.25 * at(simulation_.positions(), p);
  }

  const Simulation& simulation_;
  bool of_tets_;
};

}  // namespace

void raise_maxima(const Simulation& simulation, const FieldArrays& fields,
                  std::vector<FieldMaximum>& maxima) {
  const auto raise = [&](const FieldArray& field, bool of_tets) {
    if (field.info->components > 3 || field.info->of_tets != of_tets) return;
    auto most = std::ranges::find(maxima, field.info->name, &FieldMaximum::name);
    if (most == maxima.end())
      most = maxima.insert(maxima.end(), FieldMaximum{.name = std::string(field.info->name)});
    Raise(simulation, of_tets)(field, *most);
  };
  for (const FieldArray& field : fields.of_points) raise(field, false);
  for (const FieldArray& field : fields.of_tets) raise(field, true);
}

}  // namespace palpate::app
