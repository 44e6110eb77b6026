#include "sim/holds.hpp"

#include <algorithm>
#include <string>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "sim/model_check.hpp"
#include "sim/ties.hpp"

namespace palpate {
namespace {

constexpr const char* model_change_name = "model change";

void check_index(const char* where, Index found, std::size_t count) {
  if (found >= 0 && static_cast<std::size_t>(found) < count) return;
  throw Error(model_change_name, where, std::to_string(found), "an index below " + std::to_string(count));
}

std::string title(const Bodies& bodies, Index body) {
  return "'" + at(bodies.bodies(), body).name + "'";
}

/// Applies the changes of a ModelChange to the constraints, one kind after the other.
class Changer {
 public:
  Changer(const Bodies& bodies, std::span<const Vec3> positions, HeldModel& held)
      : bodies_(bodies), positions_(positions), holds_(held.holds), motions_(held.motions) {}

  void insert(Index body) {
    check_index("insert", body, holds_.absent.size());
    if (at(holds_.absent, body) == 0) {
      throw Error(model_change_name, "insert", title(bodies_, body) + ", which is in the simulation already",
                  "a body that was removed, or absent at the start");
    }
    at(holds_.absent, body) = 0;
  }
  void remove(Index body) {
    check_index("remove", body, holds_.absent.size());
    check_present("remove", body);
    at(holds_.absent, body) = 1;
    std::erase_if(holds_.ties, [&](const HeldTie& held) {
      return at(bodies_.body_of_point(), held.tie.point) == body ||
             bodies_.body_of(at(bodies_.tets(), held.tie.tet)) == body;
    });
  }
  void release_body(Index body) {
    check_index("release_bodies", body, holds_.absent.size());
    check_present("release_bodies", body);
    at(holds_.obstacles, body) = 0;
    const Range points = at(bodies_.bodies(), body).points;
    for (Index p = points.begin; p < points.end; ++p) set(p, 0, -1);
  }
  void release_point(Index point) {
    check_soft("release_points", point, "the whole body, or points of one that deforms");
    set(point, 0, -1);
  }
  void fix(Index point) {
    check_soft("fix", point, "points of a body that deforms; a rigid body stands still where a move lets it");
    set(point, 1, -1);
  }
  void move(const PointMove& move) {
    if (move.points.empty()) throw Error(model_change_name, "moves", "no point", "one or more points");
    const auto number = static_cast<Index>(motions_.size());
    for (const Index point : move.points) {
      check_point("moves", point);
      set(point, at(holds_.obstacles, at(bodies_.body_of_point(), point)), number);
      at(holds_.prescribed_start, point) = at(positions_, point);
    }
    motions_.push_back(move.motion);
  }
  void untie(std::vector<Index> numbers) {
    for (const Index number : numbers) check_index("untie", number, holds_.ties.size());
    std::ranges::sort(numbers, std::greater());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    for (const Index number : numbers) holds_.ties.erase(holds_.ties.begin() + number);
  }
  void tie(const std::vector<Tie>& ties) {
    for (const HeldTie& held : held_ties(ties, bodies_, positions_)) {
      check_present("ties", at(bodies_.body_of_point(), held.tie.point));
      check_present("ties", bodies_.body_of(at(bodies_.tets(), held.tie.tet)));
      holds_.ties.push_back(held);
    }
  }

 private:
  void set(Index point, std::uint8_t fixed, Index motion) {
    at(holds_.fixed_points, point) = fixed;
    at(holds_.fixed_axes, point) = 0;
    at(holds_.motion_of_point, point) = motion;
  }
  void check_present(const char* where, Index body) const {
    if (at(holds_.absent, body) == 0) return;
    throw Error(model_change_name, where, title(bodies_, body) + ", which is not in the simulation now",
                "a body that is in it");
  }
  void check_point(const char* where, Index point) const {
    check_index(where, point, positions_.size());
    check_present(where, at(bodies_.body_of_point(), point));
  }
  void check_soft(const char* where, Index point, const char* expected) const {
    check_point(where, point);
    const Index body = at(bodies_.body_of_point(), point);
    if (at(holds_.obstacles, body) == 0) return;
    throw Error(model_change_name, where, "a point of the rigid body " + title(bodies_, body), expected);
  }

  const Bodies& bodies_;
  std::span<const Vec3> positions_;
  Holds& holds_;
  std::vector<Motion>& motions_;
};

}  // namespace

Holds holds_of(const Model& model) {
  const Bodies& bodies = model.bodies;
  const auto rest = bodies.points_rest();
  Holds holds{.obstacles = flags_or_none(model.obstacles, bodies.bodies().size(), "obstacles"),
              .absent = flags_or_none(model.absent, bodies.bodies().size(), "absent"),
              .fixed_points = flags_or_none(model.fixed_points, rest.size(), "fixed_points"),
              .fixed_axes = axes_or_none(model),
              .motion_of_point = model.motion_of_point,
              .prescribed_start = {rest.begin(), rest.end()},
              .ties = {}};
  if (holds.motion_of_point.empty()) holds.motion_of_point.assign(rest.size(), -1);
  return holds;
}

std::vector<std::uint8_t> rigid_bodies(const Holds& holds) {
  std::vector<std::uint8_t> rigid = holds.obstacles;
  for (std::size_t b = 0; b < rigid.size(); ++b) rigid[b] |= holds.absent[b];
  return rigid;
}

std::vector<std::uint8_t> bodies_at_rest(const Holds& holds, const Bodies& bodies) {
  std::vector<std::uint8_t> still = holds.obstacles;
  for (std::size_t b = 0; b < still.size(); ++b) still[b] = still[b] != 0 && holds.absent[b] == 0 ? 1 : 0;
  for (std::size_t p = 0; p < holds.motion_of_point.size(); ++p)
    if (holds.motion_of_point[p] >= 0) at(still, bodies.body_of_point()[p]) = 0;
  return still;
}

std::vector<std::uint8_t> constrained_points(const Holds& holds, const Bodies& bodies) {
  std::vector<std::uint8_t> unfree = holds.fixed_points;
  for (std::size_t p = 0; p < unfree.size(); ++p) {
    const bool moved = p < holds.motion_of_point.size() && holds.motion_of_point[p] >= 0;
    if (moved || holds.fixed_axes[p] == 7 || at(holds.absent, bodies.body_of_point()[p]) != 0) unfree[p] = 1;
  }
  return unfree;
}

std::vector<Index> motions_of_present(const Holds& holds, const Bodies& bodies) {
  std::vector<Index> motions = holds.motion_of_point;
  const std::size_t points = std::min(motions.size(), holds.fixed_points.size());
  for (std::size_t p = 0; p < points; ++p)
    if (at(holds.absent, bodies.body_of_point()[p]) != 0) motions[p] = -1;
  return motions;
}

DetectionSettings without_absent(DetectionSettings settings, std::span<const std::uint8_t> absent) {
  for (std::size_t a = 0; a < absent.size(); ++a) {
    if (absent[a] == 0) continue;
    for (std::size_t b = 0; b < absent.size(); ++b) {
      if (b < a ? absent[b] == 0 : b > a) {
        settings.ignored_pairs.push_back(
            {static_cast<Index>(std::min(a, b)), static_cast<Index>(std::max(a, b))});
      }
    }
  }
  return settings;
}

void apply_change(const ModelChange& change, const Bodies& bodies, std::span<const Vec3> positions,
                  HeldModel& held) {
  Changer changer(bodies, positions, held);
  changer.untie(change.untie);
  for (const Index body : change.insert) changer.insert(body);
  for (const Index body : change.remove) changer.remove(body);
  for (const Index body : change.release_bodies) changer.release_body(body);
  for (const Index point : change.release_points) changer.release_point(point);
  for (const Index point : change.fix) changer.fix(point);
  for (const PointMove& move : change.moves) changer.move(move);
  changer.tie(change.ties);
}

}  // namespace palpate
