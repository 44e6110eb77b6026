#include "frame_writer.hpp"

#include <algorithm>

#include "geometry/vector.hpp"

namespace palpate::app {

FrameWriter::FrameWriter(const std::filesystem::path& folder, int every, const FramesSoFar& so_far)
    : series_(folder, "frames", so_far.times), every_(every), last_step_(so_far.last_step) {}

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
  series_.add(simulation.bodies(), {.time = simulation.metrics().time,
                                    .positions = simulation.positions(),
                                    .velocities = simulation.velocities(),
                                    .in_contact = in_contact_,
                                    .depths = depths_});
  last_step_ = step;
}

}  // namespace palpate::app
