#pragma once

#include <memory>
#include <string>
#include <vector>

#include "peers/peer.hpp"

namespace palpate::bench {

/// How Embree's trees are made in a frame.
struct EmbreeMode {
  enum class Update { rebuild_low, rebuild_medium, refit };
  Update update = Update::rebuild_low;
  Grouping grouping = Grouping::one;  ///< a scene for each body, pairs by their boxes; or one for all
  [[nodiscard]] std::string name() const;
};
std::vector<EmbreeMode> every_embree_mode();

/// Embree's rtcCollide: primitives are user geometries, and the callback applies the exact test, without a
/// lock. As many threads as TBB has.
std::unique_ptr<Peer> make_embree_peer(const Course& course, const EmbreeMode& mode);

}  // namespace palpate::bench
