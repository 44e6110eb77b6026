#include "contact/edge_contacts.hpp"

#include <algorithm>
#include <tuple>

#include "contact/rim_falloff.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"
#include "geometry/vector.hpp"
#include "mesh/outward.hpp"
#include "room.hpp"
#include "simd/crossing_parameters.hpp"

namespace palpate {
namespace {

constexpr std::size_t edge_grain = 32;

}  // namespace

EdgeContactQuery::EdgeContactQuery(const Bodies& bodies, bool keeps_lists) : query_(bodies, keeps_lists) {
  for (Index b = 0; b < bodies.body_count(); ++b) slack_.push_back(rim_reach(bodies, b));
}

void EdgeContactQuery::list_groups(const Bodies& bodies, std::size_t spare) {
  const std::span<const EdgeTriangle> hits = query_.found();
  const auto key = [&](const EdgeTriangle& hit) {
    return std::pair(hit.edge, bodies.body_of(at(bodies.triangles(), hit.triangle)));
  };
  groups_.clear();
  make_room(groups_, hits.size() + spare);
  for (std::size_t begin = 0; begin < hits.size();) {
    std::size_t end = begin + 1;
    while (end < hits.size() && key(hits[end]) == key(hits[begin])) ++end;
    groups_.push_back({begin, end});
    begin = end;
  }
}

/// Finds where the edges meet the triangles.
void EdgeContactQuery::find_meetings(const parallel::Threads& threads, const Bodies& bodies,
                                     std::span<const Vec3> positions, std::size_t spare) {
  constexpr std::size_t most = simd::SegmentsInTriangles::most;
  const std::span<const EdgeTriangle> hits = query_.found();
  make_room(meetings_, hits.size() + spare);
  meetings_.resize(hits.size());
  parallel::for_chunks(threads, hits.size(), most, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::SegmentsInTriangles segments;
    for (std::size_t i = begin; i < end; ++i) {
      const Edge& ends = at(bodies.edges(), hits[i].edge);
      const Triangle& triangle = at(bodies.triangles(), hits[i].triangle);
      for (std::size_t k = 0; k < 2; ++k) segments.end[k][i - begin] = ends[k];
      for (std::size_t k = 0; k < 3; ++k) segments.corner[k][i - begin] = triangle[k];
    }
    simd::find_parameters(positions.data(), segments, end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      const double quick = segments.parameter[i - begin];
      meetings_[i] = quick >= 0.0 ? Meeting{hits[i].triangle, quick, segments.passage[i - begin] > 0.0}
                                  : exact_meeting(bodies, positions, hits[i]);
    }
  });
}

/// Where an edge meets a triangle, if double precision cannot decide.
EdgeContactQuery::Meeting EdgeContactQuery::exact_meeting(const Bodies& bodies,
                                                          std::span<const Vec3> positions,
                                                          const EdgeTriangle& hit) {
  const Edge& ends = at(bodies.edges(), hit.edge);
  const Vec3& a = at(positions, ends[0]);
  const Vec3& b = at(positions, ends[1]);
  const std::array<Vec3, 3> x = corners_of(positions, at(bodies.triangles(), hit.triangle));
  const bool enters = orient3d(x[0], x[1], x[2], a) > orient3d(x[0], x[1], x[2], b);
  return {hit.triangle, crossing_parameter(a, b, x[0], x[1], x[2]), enters};
}

/// The shortest exit of the part of an edge between two crossings.
LineExit EdgeContactQuery::shortest_exit(const Bodies& bodies, std::span<const Vec3> positions, Index edge,
                                         const Meeting& in, const Meeting& out,
                                         SilhouetteSearch& search) const {
  const Edge& ends = at(bodies.edges(), edge);
  const Vec3& a = at(positions, ends[0]);
  const Vec3 ab = at(positions, ends[1]) - a;
  const double whole = length(ab);
  const Vec3 d = normalized(ab);
  LineExit best{out.parameter * whole, d};
  const double back = (1.0 - in.parameter) * whole;
  if (back < best.distance) best = {back, -d};
  const Index body = bodies.body_of(at(bodies.triangles(), in.triangle));
  const EdgeLine line{.x = a,
                      .d = d,
                      .ends = ends,
                      .outward = outward_of_edge(bodies, positions, edge),
                      .is_own = body == bodies.body_of(ends),
                      .slack = at(slack_, body)};
  double bound = best.distance;
  for (const Meeting& meeting : {in, out}) {
    const LineExit found = search.nearest(bodies, positions, meeting.triangle, line, bound);
    if (found.direction == Vec3{}) continue;
    best = found;
    bound = found.distance + line.allowance(found.direction);
  }
  return best;
}

void EdgeContactQuery::add_rows(const Bodies& bodies, std::span<const Vec3> positions, const Group& group,
                                const PairFilter& may_touch, Scratch& scratch, std::vector<Row>& rows) const {
  const Index edge = query_.found()[group.begin].edge;
  const Edge& ends = at(bodies.edges(), edge);
  std::vector<Meeting>& meetings = scratch.meetings;
  meetings.clear();
  const auto own = std::span(meetings_).subspan(group.begin, group.end - group.begin);
  meetings.insert(meetings.end(), own.begin(), own.end());
  // An edge that passes a corner enters and leaves at one parameter.
  std::ranges::sort(meetings, {},
                    [](const Meeting& m) { return std::tuple(m.parameter, !m.enters, m.triangle); });
  const auto add = [&](const Meeting& in, const Meeting& out) {
    const LineExit exit = shortest_exit(bodies, positions, edge, in, out, scratch.search);
    rows.push_back(
        {edge, {in.triangle, out.triangle}, {in.parameter, out.parameter}, exit.distance, exit.direction});
  };
  const Index body = bodies.body_of(at(bodies.triangles(), meetings[0].triangle));
  const bool may_end_inside = body == bodies.body_of(ends) || may_touch.ties(body, bodies.body_of(ends));
  const std::size_t rows_before = rows.size();
  const Meeting* in = nullptr;
  const Meeting* out = nullptr;
  for (const Meeting& meeting : meetings) {
    if (meeting.enters && out != nullptr) {
      add(*in, *out);
      in = out = nullptr;
    }
    if (meeting.enters && in == nullptr) in = &meeting;
    if (!meeting.enters && in != nullptr) out = &meeting;
  }
  if (out != nullptr) add(*in, *out);
  // No part is inside: the edge only touches, or rounding has swapped entry and exit. An edge of the same
  // body may also begin in tissue at its own end, and one of a tied body at a point that does not touch there
  // (PairFilter::are_tied), so that its entry is not a crossing.
  if (rows.size() == rows_before && !may_end_inside) add(meetings.front(), meetings.back());
}

void EdgeContactQuery::find(const parallel::Threads& threads, const Bodies& bodies,
                            std::span<const Vec3> positions, const PairFilter& may_touch,
                            const ContactTable& contacts, EdgeContacts& found, const Deadline& deadline) {
  query_.find(threads, bodies, positions, may_touch, contacts, deadline);
  // Reserves room for edge contacts that replace contacts of points where bodies tremble, so that only the
  // first steps allocate.
  const std::size_t spare = contacts.size();
  list_groups(bodies, spare);
  find_meetings(threads, bodies, positions, spare);
  const std::size_t chunks = parallel::chunk_count(groups_.size() + spare, edge_grain);
  if (scratches_.size() < chunks) scratches_.resize(chunks + chunks / 8 + 1);
  lists_.make_room_in_all(scratches_.size(), 2 * edge_grain);
  lists_.fill(threads, groups_.size(), edge_grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t g = begin; g < end; ++g)
                  add_rows(bodies, positions, groups_[g], may_touch, scratches_[begin / edge_grain], rows);
              });
  make_room(rows_, groups_.size() + spare);
  lists_.join(threads, rows_);
  const auto resize = [&](auto& column) {
    make_room(column, rows_.size() + spare);
    column.resize(rows_.size());
  };
  std::apply(
      [&](auto&... column) { (resize(column), ...); },
      std::tie(found.edge, found.body, found.triangles, found.parameters, found.depth, found.direction));
  parallel::for_each(threads, rows_.size(), 8 * edge_grain, [&](std::size_t i) {
    const Row& row = rows_[i];
    found.edge[i] = row.edge;
    found.body[i] = bodies.body_of(at(bodies.triangles(), row.triangles[0]));
    found.triangles[i] = row.triangles;
    found.parameters[i] = row.parameters;
    found.depth[i] = row.depth;
    found.direction[i] = row.direction;
  });
}

}  // namespace palpate
