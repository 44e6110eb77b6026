#include "view/player.hpp"

#include <algorithm>
#include <exception>
#include <type_traits>

#include <palpate/error.hpp>

#include "view/frame.hpp"

namespace palpate::view {
namespace {

using Json = nlohmann::ordered_json;
using Seconds = std::chrono::duration<double>;

constexpr Seconds frame_interval(1.0 / 60.0);

Player::Clock::duration ticks(double seconds) {
  return std::chrono::duration_cast<Player::Clock::duration>(Seconds(seconds));
}

/// Seconds per unit of time of the scene.
double seconds_per_unit(const Json& about) {
  const std::string unit = about.at("units").at("time");
  if (unit == "ms") return 1e-3;
  if (unit == "us") return 1e-6;
  return 1.0;
}

Json phases_json(const PhaseSeconds& seconds, std::int64_t steps) {
  Json json = Json::object();
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    json[std::string(phase_names[i])] = steps == 0 ? 0.0 : 1e3 * seconds[i] / static_cast<double>(steps);
  }
  return json;
}

template <class T, class... Types>
concept one_of = (std::is_same_v<T, Types> || ...);

}  // namespace

Player::Player(std::unique_ptr<Source> source, const PlayerSettings& settings, std::function<void()> on_news)
    : source_(std::move(source)),
      surface_(source_->bodies()),
      stage_(std::make_shared<std::string>(stage_message(*source_, surface_))),
      on_news_(std::move(on_news)),
      alone_(settings.alone),
      playing_(settings.playing),
      speed_(settings.speed),
      status_(totals_text()),
      thread_([this] { run(); }) {}

void Player::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) thread_.join();
}

bool Player::post(Client client, Command command) {
  {
    const std::scoped_lock lock(mutex_);
    if (commands_.size() >= most_commands) return false;
    commands_.emplace_back(client, std::move(command));
  }
  changed_.notify_one();
  return true;
}

void Player::join(Client /*client*/) {
  {
    const std::scoped_lock lock(mutex_);
    ++pages_;
  }
  changed_.notify_one();
}

void Player::leave(Client client) {
  {
    const std::scoped_lock lock(mutex_);
    --pages_;
    ended_.push_back(client);
  }
  changed_.notify_one();
}

void Player::display(const DisplayOptions& display) {
  {
    const std::scoped_lock lock(mutex_);
    display_changed_ = display_changed_ || !(display_ == display);
    display_ = display;
  }
  changed_.notify_one();
}

void Player::want_frame() {
  {
    const std::scoped_lock lock(mutex_);
    frame_wanted_ = true;
  }
  changed_.notify_one();
}

News Player::news() const {
  const std::scoped_lock lock(mutex_);
  return news_;
}

std::vector<Refusal> Player::pop_refusals() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(refusals_, {});
}

std::string Player::status() const {
  const std::scoped_lock lock(mutex_);
  return status_;
}

void Player::refuse(Client client, const std::string& why) {
  const std::scoped_lock lock(mutex_);
  if (refusals_.size() < most_commands) refusals_.push_back({client, why});
}

void Player::run() {
  while (wait()) {
    try {
      run_commands();
      if (runs() && Clock::now() >= next_step_) advance();
      if (state_stale_) publish_state();
      if (frame_is_due(Clock::now())) publish_frame();
    } catch (const std::exception& error) {  // for example out of memory: pages must be informed
      fail(error.what());
    }
  }
}

void Player::fail(const std::string& why) {
  error_ = why;
  playing_ = false;
  state_stale_ = true;
}

bool Player::runs() const {
  if (!playing_ || !source_->interval()) return false;
  const std::scoped_lock lock(mutex_);
  return alone_ || pages_ > 0;
}

bool Player::frame_is_due(Clock::time_point now) const {
  const std::scoped_lock lock(mutex_);
  return frame_wanted_ && (frame_stale_ || display_changed_) && now >= next_frame_;
}

/// Waits until there is something to do; false at the end.
bool Player::wait() {
  const bool can_run = playing_ && source_->interval();
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    const Clock::time_point now = Clock::now();
    const bool step = can_run && (alone_ || pages_ > 0);
    const bool frame = frame_wanted_ && (frame_stale_ || display_changed_);
    if (!commands_.empty() || !ended_.empty() || state_stale_ || (step && now >= next_step_) ||
        (frame && now >= next_frame_))
      break;
    Clock::time_point until = Clock::time_point::max();
    if (step) until = std::min(until, next_step_);
    if (frame) until = std::min(until, next_frame_);
    if (until == Clock::time_point::max()) {
      changed_.wait(lock);
    } else {
      changed_.wait_until(lock, until);
    }
  }
  return !stopping_;
}

void Player::run_commands() {
  std::vector<Client> gone;
  taken_.clear();
  {
    const std::scoped_lock lock(mutex_);
    std::swap(taken_, commands_);
    std::swap(gone, ended_);
  }
  for (auto& [client, command] : taken_) {
    try {
      execute(client, command);
    } catch (const Error& error) {
      refuse(client, error.what());
      on_news_();
    }
  }
  for (const Client client : gone) source_->forget(client);
}

void Player::execute(Client client, Command& command) {
  std::visit(
      [&](auto& what) {
        using What = std::remove_cvref_t<decltype(what)>;
        if constexpr (std::is_same_v<What, Play>) {
          if (what.on && !source_->interval()) source_->reset();
          playing_ = what.on && error_.empty();
        } else if constexpr (std::is_same_v<What, SetSpeed>) {
          speed_ = what.speed;
          next_step_ = {};
        } else if constexpr (std::is_same_v<What, StepOnce>) {
          playing_ = false;
          if (source_->interval() && error_.empty()) advance();
        } else if constexpr (std::is_same_v<What, Reset>) {
          source_->reset();
          error_.clear();
          since_frame_ = {};
          since_start_ = {};
          simulated_ = 0.0;
        } else if constexpr (!one_of<What, DisplayOptions, Shown>) {  // the server handles these two
          source_->apply(client, what);
        }
      },
      command);
  frame_stale_ = true;
  state_stale_ = true;
}

void Player::advance() {
  const double before = source_->time();
  const double interval = source_->interval().value_or(0.0);
  const std::size_t stages = source_->begun_stages();
  try {
    source_->advance();
  } catch (const Error& error) {
    return fail(error.what());
  }
  if (speed_) {
    const Clock::time_point now = Clock::now();
    next_step_ = std::max(next_step_ + ticks(interval * seconds_per_unit(source_->stage().about) / *speed_),
                          now - ticks(0.1));
  }
  if (source_->begun_stages() != stages) state_stale_ = true;
  simulated_ += source_->time() - before;
  for (Totals* totals : {&since_frame_, &since_start_}) {
    ++totals->steps;
    for (std::size_t i = 0; i < phase_names.size(); ++i) totals->seconds[i] += source_->seconds()[i];
    totals->longest = std::max(totals->longest, source_->seconds().back());
  }
  frame_stale_ = true;
  if (!source_->interval()) {  // the end
    playing_ = false;
    state_stale_ = true;
  }
  const std::string status = totals_text();
  const std::scoped_lock lock(mutex_);
  status_ = status;
}

/// What status() returns.
std::string Player::totals_text() const {
  return Json{{"steps", since_start_.steps},
              {"simulated", simulated_},
              {"time", source_->time()},
              {"step_seconds", since_start_.seconds.back()}}
      .dump();
}

void Player::publish_frame() {
  DisplayOptions display;
  {
    const std::scoped_lock lock(mutex_);
    display = display_;
    display_changed_ = false;
    frame_wanted_ = false;
  }
  const std::uint64_t number = news_.frame_number + 1;  // only this thread writes it
  Json header{{"frame", number},
              {"playing", playing_},
              {"steps", since_frame_.steps},
              {"ms", phases_json(since_frame_.seconds, since_frame_.steps)},
              {"longest", 1e3 * since_frame_.longest},
              {"totals",
               {{"steps", since_start_.steps},
                {"simulated", simulated_},
                {"longest", 1e3 * since_start_.longest},
                {"ms", phases_json(since_start_.seconds, since_start_.steps)}}}};
  auto frame =
      std::make_shared<const std::string>(frame_message(*source_, surface_, display, std::move(header)));
  since_frame_ = {};
  frame_stale_ = false;
  next_frame_ =
      std::max(next_frame_ + ticks(frame_interval.count()), Clock::now() - ticks(frame_interval.count()));
  {
    const std::scoped_lock lock(mutex_);
    news_.frame = std::move(frame);
    news_.frame_number = number;
  }
  on_news_();
}

void Player::publish_state() {
  Json state{{"kind", "state"},
             {"playing", playing_},
             {"speed", speed_ ? Json(*speed_) : Json("max")},
             {"settings", source_->settings()},
             {"error", error_}};
  {
    const std::scoped_lock lock(mutex_);
    state["pages"] = pages_;
    news_.state =
        std::make_shared<const std::string>(state.dump(-1, ' ', false, Json::error_handler_t::replace));
    ++news_.state_number;
  }
  state_stale_ = false;
  on_news_();
}

}  // namespace palpate::view
