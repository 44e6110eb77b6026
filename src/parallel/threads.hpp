#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace palpate::parallel {

/// Threads that work together on the chunks of a loop. Passed down, never global; copies share the same
/// threads.
///
/// The calling thread works too. Each thread begins with its own part of the chunks, so that loops over the
/// same data leave them in its cache; who has none left takes chunks of the others. The loop ends when all
/// chunks are done. Of a thread that the system has suspended, others do all chunks that it has not begun. On
/// a machine with other work, a loop is at worst about as slow as on one thread. (OpenMP's run-time waits for
/// every thread of the team at each loop; with both cores of our test machine busy, that made steps 8 to 100
/// times slower.)
class Threads {
 public:
  static constexpr int most = 1024;

  /// Throws Error if count is negative or more than `most`.
  /// \param count  threads including the caller; 0 takes as many as the process may use. If the system gives
  ///               fewer, count() returns that number
  explicit Threads(int count = 0);

  [[nodiscard]] int count() const { return count_; }

  /// Calls body(chunk) for each chunk in [0, chunks), in any order, each once; returns when all are done.
  /// `body` must not throw. Where another thread is already in run() of a copy, the caller does all chunks
  /// alone.
  template <class Body>
  void run(std::size_t chunks, Body&& body) const {
    using Plain = std::remove_reference_t<Body>;
    run_chunks(
        chunks, [](void* context, std::size_t chunk) { (*static_cast<Plain*>(context))(chunk); },
        const_cast<std::remove_const_t<Plain>*>(&body));
  }

 private:
  class Team;
  using Function = void (*)(void* context, std::size_t chunk);
  void run_chunks(std::size_t chunks, Function function, void* context) const;

  int count_;
  std::shared_ptr<Team> team_;  ///< null where the caller is the only thread
};

}  // namespace palpate::parallel
