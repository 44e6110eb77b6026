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
/// microseconds, longer than from one loop of a step to the next.
constexpr int spins = 2000;

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

/// The threads beside the caller, and the loop that they work on.
///
/// `ticket_` holds the number of the loop (high half) and its next chunk (low half). A chunk is claimed by
/// raising the ticket from a value that was read; this fails once the loop is over, because its ticket is
/// closed before anything of the next loop is written. So a thread that has claimed a chunk has the right
/// function.
class Threads::Team {
 public:
  explicit Team(int workers) {
    workers_.reserve(static_cast<std::size_t>(workers));
    try {
      for (int i = 0; i < workers; ++i) workers_.emplace_back([this] { work(); });
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
    chunks_.store(chunks, std::memory_order_release);
    ++loop_;
    ticket_.store(std::uint64_t{loop_} << 32, std::memory_order_release);
    wake();
    claim_chunks();
    for (int i = 0; done_.load(std::memory_order_acquire) != chunks; ++i) {
      if (i < spins) {
        pause();
      } else {
        std::this_thread::yield();
      }
    }
    ticket_.store(std::uint64_t{loop_} << 32 | closed, std::memory_order_release);
    return true;
  }

 private:
  static constexpr std::uint64_t closed = std::numeric_limits<std::uint32_t>::max();

  void wake() {
    calls_.fetch_add(1, std::memory_order_release);
    calls_.notify_all();
  }

  /// Claims and runs chunks of the current loop until none is left.
  void claim_chunks() {
    std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
    while ((ticket & closed) < chunks_.load(std::memory_order_acquire)) {
      if (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel,
                                         std::memory_order_acquire)) {
        continue;
      }
      function_.load(std::memory_order_relaxed)(context_.load(std::memory_order_relaxed), ticket & closed);
      done_.fetch_add(1, std::memory_order_release);
      ticket = ticket_.load(std::memory_order_acquire);
    }
  }

  void work() {
    std::uint32_t seen = 0;
    while (!stop_.load(std::memory_order_relaxed)) {
      claim_chunks();
      int idle = 0;
      while (calls_.load(std::memory_order_acquire) == seen && idle < spins) {
        pause();
        ++idle;
      }
      if (idle == spins) calls_.wait(seen, std::memory_order_acquire);
      seen = calls_.load(std::memory_order_acquire);
    }
  }

  std::mutex mutex_;  ///< held by the caller of run()
  std::uint32_t loop_ = 0;
  alignas(64) std::atomic<std::uint64_t> ticket_{closed};
  alignas(64) std::atomic<std::uint32_t> done_{0};
  alignas(64) std::atomic<std::uint32_t> calls_{0};  ///< changes with every loop: what idle threads wait for
  std::atomic<std::uint32_t> chunks_{0};
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
