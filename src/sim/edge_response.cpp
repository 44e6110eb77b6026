#include "sim/edge_response.hpp"

#include <algorithm>

#include "room.hpp"
#include "sim/response.hpp"

namespace palpate {
namespace {

constexpr std::size_t edge_row_grain = 64;

}  // namespace

/// Makes all rows but insets, not sorted, without slip and damping.
void EdgeResponse::list(const Frame& frame) {
  // Reserves room for contacts that begin and end, so that only the first steps allocate.
  const std::size_t room = 2 * frame.table.size();
  for (auto* list : {&now_, &before_}) make_room(*list, room);
  make_room(rows_, room);
  const std::size_t crossings = frame.surfaces.crossings->all().size();
  const std::size_t chunks =
      parallel::chunk_count(std::max(room + frame.table.edges().size(), crossings), edge_row_grain);
  lists_.make_room_in_all(chunks, 2 * edge_row_grain);
  if (searches_.size() < chunks) searches_.resize(chunks + chunks / 8 + 1);
  measure_support(frame);
  list_edge_contacts(frame);
  list_rim_edges(frame);
}

void EdgeResponse::measure_support(const Frame& frame) {
  const Contacts& contacts = frame.table.contacts();
  support_.measure(frame.bodies, frame.positions, contacts, frame.scales);
  const ContactStates& states = frame.table.states();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (states.soft[c] == 0) continue;
    const Index own = at(frame.bodies.body_of_point(), contacts.point[c]);
    const double usual = frame.scales[c] * frame.rules.stiffness(own, contacts.body[c]);
    support_.soften(own, contacts.body[c], states.stiffness[c] / usual);
  }
  for (auto* list : {&unsupported_, &at_rims_}) {
    list->clear();
    make_room(*list, contacts.size());
  }
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const double lack = support_.lack(at(frame.bodies.body_of_point(), contacts.point[c]), contacts.body[c]);
    if (lack > 0.0) unsupported_.push_back(static_cast<Index>(c));
    if (lack < 1.0 && frame.scales[c] < 1.0) at_rims_.push_back(static_cast<Index>(c));
  }
}

void EdgeResponse::list_edge_contacts(const Frame& frame) {
  const EdgeContacts& edges = frame.table.edges();
  make_room(numbers_, frame.table.size());
  resize_with_room(numbers_, edges.size());
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const bool same = c > 0 && edges.edge[c] == edges.edge[c - 1] && edges.body[c] == edges.body[c - 1];
    numbers_[c] = same ? numbers_[c - 1] + 1 : 0;
  }
  lists_.fill(frame.threads, edges.size(), edge_row_grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t c = begin; c < end; ++c) add_edge_contact(frame, c, numbers_[c], rows);
              });
  lists_.join(frame.threads, rows_);
}

template <class Add>
void EdgeResponse::append_rows(const Frame& frame, std::size_t size, const Add& add) {
  lists_.fill(frame.threads, size, edge_row_grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t i = begin; i < end; ++i) add(i, searches_[begin / edge_row_grain], rows);
              });
  lists_.append(frame.threads, rows_, parallel::chunk_count(size, edge_row_grain));
}

void EdgeResponse::list_rim_edges(const Frame& frame) {
  append_rows(frame, unsupported_.size(), [&](std::size_t i, RimEdgeSearch& search, std::vector<Row>& rows) {
    add_rim_edges(frame, static_cast<std::size_t>(unsupported_[i]), search, rows);
  });
}

void EdgeResponse::list_insets(const Frame& frame) {
  append_rows(frame, at_rims_.size(), [&](std::size_t i, RimEdgeSearch& search, std::vector<Row>& rows) {
    add_insets(frame, static_cast<std::size_t>(at_rims_[i]), search, rows);
  });
  append_rows(frame, frame.surfaces.crossings->all().size(),
              [&](std::size_t i, RimEdgeSearch& search, std::vector<Row>& rows) {
                add_inset_of_border_edge(frame, i, search, rows);
              });
}

void EdgeResponse::sort_rows() {
  std::ranges::sort(rows_, {}, [](const Row& row) { return row.end.key(); });
}

std::span<const EdgeResponse::Row> EdgeResponse::begin(const Frame& frame) {
  now_.swap(before_);
  list(frame);
  list_insets(frame);
  sort_rows();
  resize_with_room(now_, rows_.size());
  parallel::for_each(frame.threads, rows_.size(), edge_row_grain, [&](std::size_t i) {
    EdgeEnd& end = rows_[i].end;
    const fem::Coupling coupling = end.coupling();
    end.velocity = fem::relative(coupling, frame.velocities);
    const auto last = std::ranges::lower_bound(before_, end.key(), {}, &EdgeEnd::key);
    if (last != before_.end() && last->key() == end.key()) {
      if (last->lost == 0)
        end.law.slip = frame.rules.bounded_slip(last->law.slip + frame.since * end.velocity, end.law);
      const Index own = at(frame.bodies.body_of_point(), end.points[0]);
      end.chatter_damping =
          frame.rules.chatter_damping({.force = (last->law.stiffness * last->law.depth) * last->law.direction,
                                       .direction = last->law.direction,
                                       .velocity = last->velocity,
                                       .stiffness = last->law.stiffness,
                                       .damping = last->chatter_damping,
                                       .comes_back = last->lost > 0},
                                      (end.law.stiffness * end.law.depth) * end.law.direction, end.velocity,
                                      frame.rules.stiffness(own, end.body));
    }
    end.law.damping = frame.rules.damping(coupling, end.law.stiffness) + end.chatter_damping;
    end.acts = true;
    now_[i] = end;
  });
  return rows_;
}

std::span<const EdgeResponse::Row> EdgeResponse::near(const Frame& frame) {
  rows_.clear();
  make_room(rows_, before_.size());
  const auto present = static_cast<std::ptrdiff_t>(now_.size());
  make_room(now_, now_.size() + before_.size());
  for (const EdgeEnd& last : before_) {
    const auto here = std::span(now_).first(static_cast<std::size_t>(present));
    if (last.lost >= ContactTable::longest_absence ||
        std::ranges::binary_search(here, last.key(), {}, &EdgeEnd::key))
      continue;
    EdgeEnd& state = now_.emplace_back(last);
    ++state.lost;
    state.acts = false;
    if (!last.acts || last.end == EdgeEnd::inset) continue;
    EdgeEnd end = last;
    end.law.damping = 0.0;
    end.law.slip = {};
    const fem::Coupling coupling = end.coupling();
    const Vec3 apart = fem::relative(coupling, frame.positions);
    const Vec3& direction = end.law.direction;
    const double depth = end.law.depth - dot(apart, direction);
    const Vec3 slid = apart - dot(apart, direction) * direction;
    const double speed = length(fem::relative(coupling, frame.velocities));
    state.acts = depth <= 0.0 && -depth <= frame.time_step * speed + frame.fall &&
                 length(slid) <= frame.rules.rim_reach(last.body);
    if (state.acts) rows_.push_back({.end = end, .depth = depth});
  }
  std::ranges::sort(now_, {}, &EdgeEnd::key);
  return rows_;
}

bool EdgeResponse::acts(const EdgeEnd& end) const {
  const auto place = std::ranges::lower_bound(now_, end.key(), {}, &EdgeEnd::key);
  return place != now_.end() && place->key() == end.key() && place->acts;
}

std::span<const EdgeResponse::Row> EdgeResponse::meet(const Frame& frame) {
  list(frame);
  sort_rows();
  std::erase_if(rows_, [&](const Row& row) { return acts(row.end); });
  for (auto& [end, depth, force] : rows_) {
    end.acts = true;
    // Depth before the step, on the straight line of the motion. Not above zero, since the end was outside.
    end.velocity = fem::relative(end.coupling(), frame.velocities);
    depth = std::min(depth + frame.time_step * dot(end.velocity, end.law.direction), 0.0);
    fem::ContactLaw law = end.law;
    law.depth = depth;
    force = fem::contact_force(law, {.coefficient = 0.0, .time_step = frame.time_step}, end.velocity).normal;
  }
  std::erase_if(rows_, [](const Row& row) { return row.force == 0.0; });
  return rows_;
}

void EdgeResponse::take() {
  make_room(now_, now_.size() + rows_.size());
  const auto known = static_cast<std::ptrdiff_t>(now_.size());
  for (const auto& [end, depth, force] : rows_) {
    const auto here = std::span(now_).first(static_cast<std::size_t>(known));
    const auto gone = std::ranges::lower_bound(here, end.key(), {}, &EdgeEnd::key);
    if (gone == here.end() || gone->key() != end.key()) {
      now_.push_back(end);
      continue;
    }
    const std::int32_t lost = gone->lost;
    const double damping = gone->chatter_damping;
    *gone = end;
    gone->lost = lost;
    gone->chatter_damping = damping;
  }
  std::ranges::sort(now_, {}, &EdgeEnd::key);
}

}  // namespace palpate
