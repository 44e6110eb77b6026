#include "contact/contact_list.hpp"

#include <algorithm>

#include "geometry/predicates.hpp"
#include "room.hpp"
#include "sort/rows.hpp"

namespace palpate {

void ContactList::assign(const parallel::Threads& threads, const Bodies& bodies,
                         std::span<const Vec3> positions, std::span<const PointInTet> found) {
  const std::size_t n_points = bodies.points_rest().size();
  sort_into_rows(
      found, n_points, [](const PointInTet& f) { return f.point; }, row_begin_, by_point_);
  for (std::vector<Index>* list : {&contacts_.point, &contacts_.body, &contacts_.tet}) {
    list->clear();
    make_room(*list, found.size());
  }
  of_point_.resize(n_points);
  for (std::size_t p = 0; p < n_points; ++p) {
    OfPoint& of_point = of_point_[p];
    of_point = {static_cast<Index>(contacts_.size()), 0, -1};
    // Bodies ascend with their tets.
    if (row_begin_[p + 1] - row_begin_[p] > 1) {
      std::sort(by_point_.begin() + row_begin_[p], by_point_.begin() + row_begin_[p + 1],
                [](const PointInTet& a, const PointInTet& b) { return a.tet < b.tet; });
    }
    Index last_body = -1;
    for (Index f = row_begin_[p]; f < row_begin_[p + 1]; ++f) {
      const Index tet = at(by_point_, f).tet;
      const Index body = bodies.body_of(at(bodies.tets(), tet));
      if (body == last_body) continue;
      last_body = body;
      if (of_point.count++ == 0) of_point.body = body;
      contacts_.point.push_back(static_cast<Index>(p));
      contacts_.body.push_back(body);
      contacts_.tet.push_back(tet);
    }
  }

  const std::size_t n = contacts_.size();
  resize_with_room(contacts_.weights, n);
  assign_with_room(contacts_.depth, n, 0.0);
  assign_with_room(contacts_.direction, n, Vec3{});
  assign_with_room(contacts_.certainty, n, 0.0);
  parallel::for_each(threads, n, 512, [&](std::size_t c) {
    const Tet& tet = at(bodies.tets(), contacts_.tet[c]);
    contacts_.weights[c] =
        barycentric_weights(at(positions, contacts_.point[c]), at(positions, tet[0]), at(positions, tet[1]),
                            at(positions, tet[2]), at(positions, tet[3]));
  });
}

}  // namespace palpate
