#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "view/source.hpp"

namespace palpate::view {

/// Initial settings of a player.
struct PlayerSettings {
  bool playing = true;
  bool alone = false;           ///< continue while no page is open
  std::optional<double> speed;  ///< see SetSpeed
};

/// The newest messages for pages; null before the first one.
struct News {
  std::shared_ptr<const std::string> frame;  ///< a binary message
  std::uint64_t frame_number = 0;            ///< 0: none yet
  std::shared_ptr<const std::string> state;  ///< JSON: playing, speed, settings, error
  std::uint64_t state_number = 0;
};

/// Why a command was refused, for the page that sent it.
struct Refusal {
  Client client;
  std::string why;
};

/// Runs a source in a thread of its own, takes commands of pages and keeps the newest frame for them.
///
/// It never waits for a page: frames are made on request (want_frame()), at most 60 per second, and a new one
/// replaces the last. Commands wait in a queue of bounded length. All members may be called from any thread.
class Player {
 public:
  using Clock = std::chrono::steady_clock;
  /// Largest number of waiting commands; further ones are refused.
  static constexpr std::size_t most_commands = 1024;

  /// \param on_news  called in the thread of the player for each new message; must be short
  Player(std::unique_ptr<Source> source, const PlayerSettings& settings, std::function<void()> on_news);
  ~Player() { stop(); }
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  /// Ends the thread after the current step. No messages come after that.
  void stop();

  /// Adds a command; returns false if the queue is full.
  bool post(Client client, Command command);
  void join(Client client);
  void leave(Client client);
  /// Sets the data that any page needs beside positions.
  void display(const DisplayOptions& display);
  /// Call when a page is ready for a newer frame.
  void want_frame();

  [[nodiscard]] News news() const;
  [[nodiscard]] std::vector<Refusal> pop_refusals();
  /// The message that describes the bodies.
  [[nodiscard]] const std::shared_ptr<const std::string>& stage() const { return stage_; }
  /// JSON for scripts: steps and simulated time since the start of the player, wall-clock seconds while it
  /// played.
  [[nodiscard]] std::string status() const;

 private:
  struct Totals {
    std::int64_t steps = 0;
    PhaseSeconds seconds{};
    double longest = 0.0;
  };
  void run();
  bool wait();
  void run_commands();
  void execute(Client client, Command& command);
  void advance();
  void fail(const std::string& why);
  void publish_frame();
  void publish_state();
  [[nodiscard]] std::string totals_text() const;
  void refuse(Client client, const std::string& why);
  [[nodiscard]] bool runs() const;
  [[nodiscard]] bool frame_is_due(Clock::time_point now) const;

  // Used only by the thread of the player:
  std::unique_ptr<Source> source_;
  Surface surface_;
  std::shared_ptr<const std::string> stage_;
  std::function<void()> on_news_;
  bool alone_;
  bool playing_;
  std::optional<double> speed_;
  std::string error_;
  Clock::time_point next_step_{};
  Clock::time_point next_frame_{};
  bool frame_stale_ = true;
  bool state_stale_ = true;
  Totals since_frame_;
  Totals since_start_;
  double simulated_ = 0.0;
  std::vector<std::pair<Client, Command>> taken_;

  mutable std::mutex mutex_;  ///< protects the members below; held for short times only
  std::condition_variable changed_;
  std::vector<std::pair<Client, Command>> commands_;
  std::vector<Client> ended_;
  std::vector<Refusal> refusals_;
  News news_;
  DisplayOptions display_;
  std::size_t pages_ = 0;
  bool frame_wanted_ = false;
  bool display_changed_ = false;
  bool stopping_ = false;
  std::string status_;

  std::thread thread_;
};

}  // namespace palpate::view
