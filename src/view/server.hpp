#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "view/player.hpp"

namespace palpate::view {

struct ServerSettings {
  std::string host = "127.0.0.1";  ///< address to listen at
  std::uint16_t port = 0;          ///< 0: any free port
  std::string token;               ///< see is_token()
  std::vector<std::string> names;  ///< further host names of this server
};

/// Whether a text is an IP address at which a server can listen.
bool is_address(const std::string& host);

/// Serves the page over HTTP and the player's messages over WebSockets, in the thread that calls run_for().
///
/// For each page the newest frame wins: at most two are in flight, and the page reports each frame that it
/// has drawn.
class Server {
 public:
  /// Starts to listen. Throws Error if that fails.
  Server(const ServerSettings& settings, std::unique_ptr<Source> source, const PlayerSettings& player);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  /// The address of the page: "http://127.0.0.1:PORT/TOKEN/".
  [[nodiscard]] std::string address() const;
  [[nodiscard]] Player& player();

  /// Handles requests for this time.
  void run_for(std::chrono::milliseconds time);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::view
