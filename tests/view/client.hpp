#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// A client of the server that, unlike a browser, sends any bytes it is given.
namespace palpate::test {

/// The status of the answer to a request (0: the connection was closed), and its body.
struct Answer {
  int status = 0;
  std::string body;
};

/// Sends bytes on a new connection, and reads the answer until its end.
Answer ask_raw(std::uint16_t port, const std::string& request);
/// A GET with the right Host and more headers.
Answer get(std::uint16_t port, const std::string& target, const std::string& headers = "");

/// A WebSocket.
class Socket {
 public:
  /// Connects with the right Host and Origin. Throws if the server refuses.
  Socket(std::uint16_t port, const std::string& target);
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  struct Received {
    bool binary = false;
    std::string data;
  };
  /// False if the server has closed the connection.
  bool send(const std::string& text, bool binary = false);
  /// The next message; empty if the server closed the connection.
  std::optional<Received> receive();
  /// Messages until one of that kind ("stage", "frame", "state", "refusal"), which it returns.
  Received receive_kind(const std::string& kind);
  /// The server's close code, or 0.
  [[nodiscard]] int close_code() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate::test
