#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace palpate {

/// How the clusters of a frame are queried.
enum class FrameMode {
  all,              ///< each cluster looks up its points; no lists
  list,             ///< near lists are made, then queried
  listed,           ///< only lists are queried
  listed_but_stale  ///< valid lists are queried; clusters with stale lists look up their points
};

/// Decides when near lists are used (docs/query.md, "Coherence"). It uses only counts, so it is the same on
/// every machine. The cost unit is a hundredth of the cost of one cluster without lists, including its part
/// of the grid.
///
/// After lists that cost more than they saved, no lists are made for 8 frames, then 16, and so on up to 64.
/// So frames in which everything moves cost only one or two percent more than without lists.
class ListPlan {
 public:
  /// \param stale  clusters whose lists are no longer valid; ignored without lists
  FrameMode choose(std::size_t clusters, std::size_t stale) {
    const auto n = static_cast<std::int64_t>(clusters);
    const auto s = static_cast<std::int64_t>(stale);
    if (!memory_.has_lists) return begin();
    ++memory_.age;
    if (s == 0) {
      memory_.gain += (all_cost - listed_cost) * n;
      return FrameMode::listed;
    }
    if (2 * s > n) return renew(n);
    const std::int64_t cost = grid_cost * n + (all_cost - grid_cost) * s + listed_cost * (n - s);
    memory_.gain += all_cost * n - cost;
    memory_.waste += cost - listed_cost * n;
    memory_.became_stale = memory_.became_stale || memory_.age <= 2;
    if (memory_.waste < memory_.patience * listing_cost * n) return FrameMode::listed_but_stale;
    // A body that never rests makes new lists stale as fast as old ones.
    memory_.patience = memory_.became_stale ? std::min(2 * memory_.patience, most_patience) : 1;
    return renew(n);
  }
  /// Call when the lists are no longer available.
  void drop_lists(std::size_t clusters) {
    if (memory_.has_lists) close_lists(static_cast<std::int64_t>(clusters));
  }
  [[nodiscard]] bool has_lists() const { return memory_.has_lists; }
  /// The state, as numbers to be saved.
  using Numbers = std::array<std::int64_t, 8>;
  [[nodiscard]] Numbers numbers() const {
    const Memory& m = memory_;
    return {m.has_lists, m.became_stale, m.wait, m.pause, m.patience, m.age, m.gain, m.waste};
  }
  /// Whether these numbers can be a state.
  [[nodiscard]] static bool allows(const Numbers& n) {
    constexpr std::int64_t most = std::int64_t{1} << 60;
    const auto within = [](std::int64_t x, std::int64_t low, std::int64_t high) {
      return low <= x && x <= high;
    };
    return within(n[0], 0, 1) && within(n[1], 0, 1) && within(n[2], 0, most_pause) &&
           within(n[3], 0, most_pause) && within(n[4], 1, most_patience) && within(n[5], 0, most) &&
           within(n[6], 0, most) && within(n[7], 0, most);
  }
  void set_numbers(const Numbers& n) { memory_ = {n[0] != 0, n[1] != 0, n[2], n[3], n[4], n[5], n[6], n[7]}; }

 private:
  struct Memory {
    bool has_lists = false;
    bool became_stale = false;  ///< the last lists became stale within two frames
    std::int64_t wait = 1;      ///< frames to wait before the next lists; a single detection makes none
    std::int64_t pause = 0;     ///< frames to wait after lists that did not pay for themselves
    std::int64_t patience = 1;
    std::int64_t age = 0;    ///< frames since the lists were made
    std::int64_t gain = 0;   ///< cost that the lists have saved
    std::int64_t waste = 0;  ///< cost that new lists would have saved since
  };
  static constexpr std::int64_t most_pause = 64;
  static constexpr std::int64_t most_patience = 64;
  static constexpr std::int64_t all_cost = 100;
  static constexpr std::int64_t grid_cost = 20;
  static constexpr std::int64_t listed_cost = 45;
  static constexpr std::int64_t listing_cost =
      80;  ///< cost of making the list of a cluster, in addition to a query without lists

  FrameMode begin() {
    if (memory_.wait > 0) {
      --memory_.wait;
      return FrameMode::all;
    }
    memory_.has_lists = true;
    memory_.became_stale = false;
    memory_.age = memory_.gain = memory_.waste = 0;
    return FrameMode::list;
  }
  FrameMode renew(std::int64_t clusters) {
    close_lists(clusters);
    return begin();
  }
  void close_lists(std::int64_t clusters) {
    const bool paid = memory_.gain >= listing_cost * clusters;
    memory_.pause = paid ? 0 : std::clamp<std::int64_t>(2 * memory_.pause, 8, most_pause);
    memory_.wait = memory_.pause;
    memory_.has_lists = false;
  }

  Memory memory_;
};

}  // namespace palpate
