#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/settings.hpp>

#include "contact/allowance.hpp"
#include "contact/query_tally.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Orders clusters by importance, for a query that may not have time for all. The classes are: clusters that
/// found something in their last query; those that have waited for 31 detections; those that had candidates
/// in their last query, first those in the region of interest; all others, first those in the region of
/// interest. Within a class, the clusters that have waited longest come first.
class ClusterQueue {
 public:
  explicit ClusterQueue(std::size_t clusters) : states_(clusters, 0) {}

  /// Orders the clusters of `all` for which takes(cluster) is true. O(clusters).
  template <class Takes>
  void arrange(const Clusters& all, std::span<const Vec3> positions,
               const std::optional<InterestRegion>& region, Takes&& takes) {
    count_.fill(0);
    class_of_.resize(states_.size());
    for (std::size_t c = 0; c < states_.size(); ++c) {
      const Cluster& cluster = all.clusters[c];
      class_of_[c] =
          takes(cluster) ? place_of(states_[c], region && in(*region, all, cluster, positions)) : none;
      if (class_of_[c] != none) ++count_[class_of_[c] + 1U];
    }
    for (std::size_t k = 1; k < count_.size(); ++k) count_[k] += count_[k - 1];
    urgent_ = count_[ages];
    resize(count_.back());
    for (std::size_t c = 0; c < states_.size(); ++c) {
      if (class_of_[c] == none) continue;
      const std::size_t place = count_[class_of_[c]]++;
      number_[place] = static_cast<std::uint32_t>(c);
      ordered_[place] = all.clusters[c];
    }
  }

  /// Call instead of arrange() where there is no limit: then no cluster waits.
  void clear() {
    urgent_ = 0;
    resize(0);
  }

  [[nodiscard]] std::span<const Cluster> ordered() const { return ordered_; }
  /// The number of clusters at the front of the order that found something in their last query.
  [[nodiscard]] std::size_t urgent() const { return urgent_; }
  /// The flags below for each cluster of ordered(). The query sets them.
  [[nodiscard]] std::span<std::uint8_t> answers() { return answers_; }
  static constexpr std::uint8_t asked = 1;  ///< the cluster was queried
  static constexpr std::uint8_t near = 2;   ///< the cluster had candidates
  static constexpr std::uint8_t found = 4;

  /// Stores the answers. The age of clusters that were not queried grows by one, and their bodies are marked
  /// as late. Returns the number of these clusters. O(clusters).
  std::size_t close(std::span<std::uint8_t> late_bodies);

  /// State of each cluster between detections: part of the saved state of a run.
  [[nodiscard]] const std::vector<std::uint8_t>& states() const { return states_; }
  [[nodiscard]] std::vector<std::uint8_t>& states() { return states_; }

 private:
  static constexpr std::uint8_t age_bits = 0x1f;
  static constexpr std::uint8_t state_near = 0x40;
  static constexpr std::uint8_t state_found = 0x80;
  static constexpr std::size_t ages = 32;
  static constexpr std::size_t classes = 6;
  static constexpr std::uint8_t none = 0xff;

  /// The sort key: the class first, then the age, oldest first.
  [[nodiscard]] static std::uint8_t place_of(std::uint8_t state, bool of_interest) {
    const bool is_near = (state & state_near) != 0;
    std::size_t importance = of_interest ? 4U : 5U;
    if (is_near) importance = of_interest ? 2U : 3U;
    if ((state & age_bits) == age_bits) importance = 1;
    if ((state & state_found) != 0) importance = 0;
    return static_cast<std::uint8_t>(importance * ages + (ages - 1 - (state & age_bits)));
  }
  [[nodiscard]] static bool in(const InterestRegion& region, const Clusters& all, const Cluster& cluster,
                               std::span<const Vec3> positions);
  void resize(std::size_t size);

  std::vector<std::uint8_t> states_;    ///< (n_clusters)
  std::vector<std::uint8_t> class_of_;  ///< (n_clusters)
  std::array<std::size_t, classes * ages + 1> count_{};
  std::vector<std::uint32_t> number_;  ///< cluster number of each item of ordered_
  std::vector<Cluster> ordered_;
  std::vector<std::uint8_t> answers_;
  std::size_t urgent_ = 0;
};

/// Clusters [begin, end) of a queue, which are queried until this fraction of the allowance is used up.
struct QueuePart {
  std::size_t begin;
  std::size_t end;
  double fraction;
};

/// Queries the clusters of a queue in order, chunk by chunk, until the allowance is used up. While others
/// wait, clusters that found something last time get at most seven eighths of it, so that no cluster waits
/// for ever. `ask(clusters, answers, list)` queries some clusters and returns its tally. With a budget in
/// tests, the queried clusters are the same for every thread count: results of further clusters are
/// discarded.
template <class T>
class QueueRun {
 public:
  template <class Ask>
  void run(const parallel::Threads& threads, ClusterQueue& queue, Allowance& allowance, Ask&& ask) {
    constexpr double urgent_fraction = 0.875;
    found_.clear();
    tally_ = {};
    const std::size_t urgent = queue.urgent();
    const std::size_t all = queue.ordered().size();
    const auto tests = static_cast<double>(allowance.tests());
    const std::size_t done = part(threads, queue, allowance, {0, urgent, urgent_fraction},
                                  static_cast<std::uint64_t>(urgent_fraction * tests), ask);
    const std::uint64_t least = 1;  // at least one chunk of the waiting clusters
    part(threads, queue, allowance, {urgent, all, 1.0}, std::max(allowance.tests(), least), ask);
    part(threads, queue, allowance, {done, urgent, 1.0}, allowance.tests(), ask);
  }

  [[nodiscard]] std::vector<T>& found() { return found_; }
  [[nodiscard]] const std::vector<T>& found() const { return found_; }
  [[nodiscard]] const QueryTally& tally() const { return tally_; }

 private:
  /// Clusters of a chunk: few enough that a chunk takes some microseconds, since the clock is read before
  /// each.
  static constexpr std::size_t grain = 16;
  static constexpr std::size_t chunks_at_a_time = 16;  ///< with a budget in tests

  /// Queries one part of the queue. Returns the first cluster that was not queried.
  template <class Ask>
  std::size_t part(const parallel::Threads& threads, ClusterQueue& queue, Allowance& allowance,
                   QueuePart rest, std::uint64_t tests, Ask&& ask) {
    while (rest.begin < rest.end && (allowance.timed() || tests > 0)) {
      const std::size_t most = allowance.timed() ? rest.end : rest.begin + grain * chunks_at_a_time;
      const QueuePart now{rest.begin, std::min(rest.end, most), rest.fraction};
      ask_chunks(threads, queue, allowance, now, ask);
      const std::size_t kept = take(threads, queue, allowance, now, tests);
      rest.begin += kept * grain;
      if (kept < tallies_.size() || allowance.timed()) break;
    }
    return std::min(rest.begin, rest.end);
  }

  template <class Ask>
  void ask_chunks(const parallel::Threads& threads, ClusterQueue& queue, Allowance& allowance,
                  const QueuePart& now, Ask&& ask) {
    const std::size_t count = now.end - now.begin;
    tallies_.assign(parallel::chunk_count(count, grain), {});
    lists_.fill(threads, count, grain, [&](std::size_t begin, std::size_t end, std::vector<T>& list) {
      const std::size_t first = now.begin + begin;
      if (queue.answers()[first] != 0) return;  // already queried in the first part
      if (allowance.timed() && !allowance.time_left(now.fraction)) return;
      tallies_[begin / grain] =
          ask(queue.ordered().subspan(first, end - begin), queue.answers().subspan(first, end - begin), list);
      allowance.add_finds(list.size());
    });
  }

  /// Keeps the results of the chunks that a budget in tests allows, including the chunk that exceeds it, and
  /// returns their number. With a budget in time, returns the number of chunks before the first that was not
  /// queried.
  std::size_t take(const parallel::Threads& threads, ClusterQueue& queue, Allowance& allowance,
                   const QueuePart& now, std::uint64_t& tests) {
    std::size_t kept = 0;
    if (allowance.timed()) {
      lists_.append(threads, found_, tallies_.size());
      for (const QueryTally& tally : tallies_) tally_ += tally;
      const auto answers = queue.answers().subspan(now.begin, now.end - now.begin);
      const auto first_left = std::ranges::find(answers, std::uint8_t{0});
      return static_cast<std::size_t>(first_left - answers.begin()) / grain;
    }
    while (kept < tallies_.size() && tests > 0) {
      const std::uint64_t spent = tallies_[kept].candidates;
      tests -= std::min(tests, spent);
      allowance.spend(spent);
      tally_ += tallies_[kept++];
    }
    lists_.append(threads, found_, kept);
    const std::size_t end = std::min(now.begin + kept * grain, now.end);
    std::ranges::fill(queue.answers().subspan(end, now.end - end), std::uint8_t{0});
    return kept;
  }

  parallel::ChunkedList<T> lists_;
  std::vector<T> found_;
  std::vector<QueryTally> tallies_;
  QueryTally tally_;
};

}  // namespace palpate
