#include "parallel/threads.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <palpate/error.hpp>

namespace palpate::parallel {
namespace {

/// How often a thread polls for work, or for the end of the others' work, before it yields: some ten
/// microseconds, longer than from one loop of a step to most next ones.
constexpr int spins = 2000;
/// How often an idle thread then yields before it sleeps: some hundred microseconds, longer than the work
/// between two loops of a step. To wake it costs the caller ten microseconds or more.
constexpr int yields = 400;

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

/// The threads beside the caller, and the loop that they work on.
///
/// The chunks of a loop are cut into parts of consecutive ones, one for each thread. A thread first does its
/// own part, from the front: in the next loop over the same data it has the same chunks, which are in its
/// cache. Then it claims chunks of the others' parts, from the back. So of a thread that the system has
/// suspended, others do what it has not claimed.
///
/// A part is a pair of numbers in one atomic word: the chunks that nobody has claimed. A chunk belongs to the
/// thread that has changed this word from what it has read. It reads the function after that. Until it has
/// counted the chunk, the loop is not over, and the function stays. So it does not matter if the word that it
/// has read was of an earlier loop.
class Threads::Team {
 public:
  explicit Team(int workers) : parts_(static_cast<std::size_t>(workers) + 1) {
    workers_.reserve(static_cast<std::size_t>(workers));
    try {
      for (std::size_t i = 1; i < parts_.size(); ++i) workers_.emplace_back([this, i] { work(i); });
    } catch (const std::system_error&) {
      // The system gives no more threads. The existing ones do the work, with the same result.
    }
  }
  ~Team() {
    stop_.store(true, std::memory_order_relaxed);
    wake();
    for (std::thread& worker : workers_) worker.join();
  }
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int workers() const { return static_cast<int>(workers_.size()); }

  /// Runs the loop and returns true; returns false if the team is busy.
  bool run(std::uint32_t chunks, Function function, void* context) {
    const std::unique_lock only_one(mutex_, std::try_to_lock);
    if (!only_one.owns_lock()) return false;
    function_.store(function, std::memory_order_relaxed);
    context_.store(context, std::memory_order_relaxed);
    done_.store(0, std::memory_order_relaxed);
    const auto parts = std::min(static_cast<std::uint32_t>(workers_.size() + 1), chunks);
    std::uint32_t end = 0;
    for (std::uint32_t i = 0; i < parts; ++i) {
      const std::uint32_t begin = end;
      end += chunks / parts + (i < chunks % parts ? 1 : 0);
      parts_[i].left.store(Left{begin, end}.word(), std::memory_order_release);
    }
    part_count_.store(parts, std::memory_order_release);
    wake();
    do_chunks(0, parts);
    for (int i = 0; done_.load(std::memory_order_acquire) != chunks; ++i) {
      if (i < spins) {
        pause();
      } else {
        std::this_thread::yield();
      }
    }
    return true;
  }

 private:
  /// Chunks that nobody has claimed.
  struct Left {
    std::uint32_t begin;
    std::uint32_t end;
    static Left of(std::uint64_t word) {
      return {static_cast<std::uint32_t>(word >> 32), static_cast<std::uint32_t>(word)};
    }
    [[nodiscard]] std::uint64_t word() const { return std::uint64_t{begin} << 32 | end; }
  };
  struct alignas(64) Part {
    std::atomic<std::uint64_t> left{0};
  };

  void wake() {
    calls_.fetch_add(1, std::memory_order_release);
    calls_.notify_all();
  }

  /// Does the chunks of a part that are left, and then counts them.
  void do_part(Part& part, bool from_front) {
    std::uint32_t done = 0;
    std::uint64_t word = part.left.load(std::memory_order_acquire);
    while (true) {
      Left left = Left::of(word);
      if (left.begin == left.end) break;
      const std::uint32_t chunk = from_front ? left.begin++ : --left.end;
      if (!part.left.compare_exchange_weak(word, left.word(), std::memory_order_acq_rel,
                                           std::memory_order_acquire)) {
        continue;
      }
      function_.load(std::memory_order_relaxed)(context_.load(std::memory_order_relaxed), chunk);
      ++done;
      word = part.left.load(std::memory_order_acquire);
    }
    if (done > 0) done_.fetch_add(done, std::memory_order_release);
  }

  /// Does chunks of the current loop until all are claimed.
  void do_chunks(std::size_t own, std::size_t parts) {
    for (std::size_t i = 0; i < parts; ++i) do_part(parts_[(own + i) % parts], i == 0);
  }

  void work(std::size_t own) {
    std::uint32_t seen = 0;
    while (!stop_.load(std::memory_order_relaxed)) {
      // A loop of fewer chunks than threads is left to as many threads, since more would only disturb them.
      // If the system has suspended these, the caller does all chunks.
      const std::size_t parts = part_count_.load(std::memory_order_acquire);
      if (own < parts) do_chunks(own, parts);
      const auto is_idle = [&] { return calls_.load(std::memory_order_acquire) == seen; };
      for (int i = 0; i < spins && is_idle(); ++i) pause();
      for (int i = 0; i < yields && is_idle(); ++i) std::this_thread::yield();
      if (is_idle()) calls_.wait(seen, std::memory_order_acquire);
      seen = calls_.load(std::memory_order_acquire);
    }
  }

  std::mutex mutex_;                                 ///< held by the caller of run()
  std::vector<Part> parts_;                          ///< of the caller and of each worker
  alignas(64) std::atomic<std::uint32_t> done_{0};   ///< chunks of the current loop that are counted
  alignas(64) std::atomic<std::uint32_t> calls_{0};  ///< changes with every loop: what idle threads wait for
  std::atomic<std::uint32_t> part_count_{0};         ///< of the current loop
  std::atomic<Function> function_{nullptr};
  std::atomic<void*> context_{nullptr};
  std::atomic<bool> stop_{false};
  std::vector<std::thread> workers_;
};

Threads::Threads(int count)
    : count_(count > 0 ? count : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {
  if (count < 0 || count > most) {
    throw Error("threads", "", std::to_string(count), "0 (all) to " + std::to_string(most));
  }
  if (count_ > 1) {
    team_ = std::make_shared<Team>(count_ - 1);
    count_ = team_->workers() + 1;
  }
}

void Threads::run_chunks(std::size_t chunks, Function function, void* context) const {
  constexpr std::size_t most_chunks = std::numeric_limits<std::uint32_t>::max() - 1;
  if (team_ && chunks > 1 && chunks <= most_chunks &&
      team_->run(static_cast<std::uint32_t>(chunks), function, context))
    return;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) function(context, chunk);
}

}  // namespace palpate::parallel
