#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"
#include "sim/response.hpp"

// Speculative contacts: those that a step begins without, or with a gap.
namespace palpate {
namespace {

/// New contacts wait for the next step if their forces are below this fraction of the acting forces (roots of
/// sums of squares).
constexpr double speculative_tolerance = 0.05;

}  // namespace

void ContactResponse::append_near(const parallel::Threads& threads, const Bodies& bodies, ContactTable& table,
                                  std::span<const Vec3> positions, std::span<const Vec3> velocities,
                                  double fall, std::vector<fem::Coupling>& couplings) {
  const auto near =
      kept_.near(threads, bodies, rims_, table.contacts(), positions, velocities, time_step_, fall);
  resize_with_room(speculative_, near.size());
  parallel::for_each(threads, near.size(), grain, [&](std::size_t i) {
    const NearContact& contact = near[i];
    const KeptContact& kept = contact.kept;
    speculative_[i] = speculative(coupling_of(kept.point, at(bodies.tets(), kept.tet), contact.weights),
                                  -contact.gap, contact.direction, velocities, kept);
  });
  append_speculative(table, couplings);
}

/// A contact of the predicted positions that the step began without. A point may have moved so far into a
/// body that its nearest exit is another side: the exit would have been inside at the start, too. Such a
/// point leaves through the face by which it came in, on the straight line of the motion.
ContactResponse::Speculative ContactResponse::met(const Bodies& bodies, const Contacts& contacts,
                                                  std::size_t c, std::span<const Vec3> positions_end,
                                                  std::span<const Vec3> velocities_end,
                                                  ExitSearch& search) const {
  constexpr double inside = 0.1;  // of the depth
  const Index point = contacts.point[c];
  const Index body = contacts.body[c];
  const Index tet = contacts.tet[c];
  const auto& weights = contacts.weights[c];
  const fem::Coupling coupling = coupling_of(point, at(bodies.tets(), tet), weights);
  const Vec3 velocity = fem::relative(coupling, velocities_end);
  double depth = contacts.depth[c];
  Vec3 r = contacts.direction[c];
  if (depth > rims_.inner(body) && depth + time_step_ * dot(velocity, r) > inside * depth) {
    const Vec3 back = -normalized(velocity);
    const ExitAhead entry =
        exit_ahead(bodies, positions_end, tet, at(positions_end, point), back, time_step_ * length(velocity));
    if (entry.leaves()) {
      r = face_normal(bodies, positions_end, entry.tet, entry.opposite);
      depth = entry.distance * dot(back, r);
    }
  }
  const double k = rims_.scale(bodies, positions_end, at(positions_end, point), tet, r, search) *
                   stiffness(at(bodies.body_of_point(), point), body);
  // Depth before the step, on the straight line of the motion. Not above zero, since the point was outside.
  const double before = std::min(depth + time_step_ * dot(velocity, r), 0.0);
  return speculative(coupling, before, r, velocities_end,
                     kept_contact(bodies, point, body, tet, weights, depth, r, k, positions_end));
}

/// The law of a speculative contact has no damping.
ContactResponse::Speculative ContactResponse::speculative(const fem::Coupling& coupling, double depth,
                                                          const Vec3& direction,
                                                          std::span<const Vec3> velocities,
                                                          const KeptContact& kept) const {
  const Vec3 velocity = fem::relative(coupling, velocities);
  const fem::ContactLaw law{
      .stiffness = kept.stiffness, .damping = 0.0, .depth = depth, .slip = {}, .direction = direction};
  return {.law = law,
          .coupling = coupling,
          .velocity = velocity,
          .kept = kept,
          .force = fem::contact_force(law, {.coefficient = 0.0, .time_step = time_step_}, velocity).normal};
}

/// Appends edges that do not act yet but touch at the predicted positions.
std::span<const EdgeResponse::Row> ContactResponse::meet_edges(const parallel::Threads& threads,
                                                               const Bodies& bodies,
                                                               const ContactTable& table,
                                                               std::span<const Vec3> positions_end,
                                                               std::span<const Vec3> velocities_end) {
  if (surfaces_.normals == nullptr) return {};
  resize_with_room(scales_, table.size());
  const Contacts& contacts = table.contacts();
  const ContactStates& states = table.states();
  for_each_searching(threads, contacts.size(), [&](std::size_t c, ExitSearch& search) {
    const double full = stiffness(at(bodies.body_of_point(), contacts.point[c]), contacts.body[c]);
    scales_[c] = states.seen[c] > 0 ? states.stiffness[c] / full
                                    : rims_.scale(bodies, positions_end, at(positions_end, contacts.point[c]),
                                                  contacts.tet[c], contacts.direction[c], search);
  });
  return edges_.meet({*this, surfaces_, rims_, threads, bodies, table, positions_end, velocities_end, since_,
                      time_step_, 0.0, scales_, flush_});
}

double ContactResponse::add_speculative(const parallel::Threads& threads, const Bodies& bodies,
                                        ContactTable& table, std::span<const Vec3> positions_end,
                                        std::span<const Vec3> velocities_end, double acting,
                                        std::vector<fem::Coupling>& couplings) {
  idle_.clear();
  make_room(idle_, table.size());
  for (std::size_t c = 0; c < table.size(); ++c)
    if (table.states().seen[c] == 0) idle_.push_back(c);
  resize_with_room(speculative_, idle_.size());
  for_each_searching(threads, idle_.size(), [&](std::size_t i, ExitSearch& search) {
    speculative_[i] = met(bodies, table.contacts(), idle_[i], positions_end, velocities_end, search);
  });
  std::erase_if(speculative_, [](const Speculative& contact) { return contact.force == 0.0; });
  double met_with = parallel::sum(threads, speculative_.size(), partial_, [&](std::size_t i) {
    return speculative_[i].force * speculative_[i].force;
  });
  const std::span<const EdgeResponse::Row> edges =
      meet_edges(threads, bodies, table, positions_end, velocities_end);
  for (const EdgeResponse::Row& row : edges) met_with += row.force * row.force;
  if (met_with <= speculative_tolerance * speculative_tolerance * acting * acting) return 0.0;
  append_speculative(table, couplings);
  append_edges(edges, couplings);
  edges_.take();
  return acting > 0.0 ? std::sqrt(met_with) / acting : std::numeric_limits<double>::infinity();
}

/// Counts a step without contact; the chatter damping stays.
void ContactResponse::append_speculative(ContactTable& table, std::vector<fem::Coupling>& couplings) {
  make_room(laws_, laws_.size() + speculative_.size());
  make_room(of_edge_, of_edge_.size() + speculative_.size());
  make_room(couplings, couplings.size() + speculative_.size());
  keys_.clear();
  make_room(keys_, speculative_.size());
  for (const Speculative& contact : speculative_) {
    keys_.emplace_back(contact.kept.point, contact.kept.body);
    laws_.push_back(contact.law);
    of_edge_.push_back(0);
    couplings.push_back(contact.coupling);
  }
  std::ranges::transform(speculative_, kept_.add(speculative_.size()).begin(), &Speculative::kept);
  table.add_rows(keys_);
  ContactStates& states = table.states();
  for (const Speculative& contact : speculative_) {
    const auto row = static_cast<std::size_t>(table.row_of(contact.kept.point, contact.kept.body));
    states.seen[row] = 1;
    states.speculative[row] = 1;
    states.slip[row] = {};
    states.force[row] = (contact.law.stiffness * contact.law.depth) * contact.law.direction;
    states.direction[row] = contact.law.direction;
    states.velocity[row] = contact.velocity;
    states.stiffness[row] = contact.law.stiffness;
  }
}

}  // namespace palpate
