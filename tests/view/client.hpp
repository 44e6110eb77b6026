#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// A client of the server, as far from a browser as can be: what it sends, it sends as it is told.
namespace palpate::test {

/// The status of the answer to a request (0: the connection was closed), and its body.
struct Answer {
  int status = 0;
  std::string body;
};

/// Sends bytes on a new connection, and reads the answer until its end.
Answer ask_raw(std::uint16_t port, const std::string& request);
/// A GET with the right Host, and whatever else.
Answer get(std::uint16_t port, const std::string& target, const std::string& headers = "");

/// A WebSocket.
class Socket {
 public:
  /// With the right Host and Origin. Throws where the server does not take it.
  Socket(std::uint16_t port, const std::string& target);
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  struct Received {
    bool binary = false;
    std::string data;
  };
  /// False where the server has closed the connection.
  bool send(const std::string& text, bool binary = false);
  /// The next message; nothing where the server closed the connection.
  std::optional<Received> receive();
  /// Messages until one of that kind ("stage", "frame", "state", "refusal"), which it returns.
  Received receive_kind(const std::string& kind);
  /// The code that the server closed with; 0: none.
  [[nodiscard]] int close_code() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::test
