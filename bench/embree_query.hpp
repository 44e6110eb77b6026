#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/pair_filter.hpp"
#include "contact/point_in_tet.hpp"

namespace palpate::bench {

/// How Embree gets its trees in a frame.
struct EmbreeMode {
  enum class Update { rebuild_low, rebuild_medium, refit };
  Update update = Update::rebuild_low;
  bool per_body = false;  ///< a scene for each body, pairs by their boxes; otherwise one scene for all
  [[nodiscard]] std::string name() const;
};
std::vector<EmbreeMode> every_embree_mode();

/// Points in tets by Embree's rtcCollide: points and tets are user geometries, and the callback tests each
/// pair of boxes with our exact predicate. One thread, no lock.
class EmbreeQuery {
 public:
  EmbreeQuery(const Bodies& bodies, const PairFilter& may_touch, const EmbreeMode& mode);
  ~EmbreeQuery();
  EmbreeQuery(const EmbreeQuery&) = delete;
  EmbreeQuery& operator=(const EmbreeQuery&) = delete;
  std::span<const PointInTet> find(std::span<const Vec3> positions);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::bench
