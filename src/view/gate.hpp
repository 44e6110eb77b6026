#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::view {

/// The parts of a request that are checked.
struct Knock {
  std::string_view method;
  std::string_view target;  ///< path and query
  std::string_view host;    ///< value of the Host header; empty if there is none, or more than one
  std::optional<std::string_view> origin;
  bool is_socket = false;  ///< asks for a WebSocket
};

/// The decision on a request: accepted, or refused with a reason.
struct Verdict {
  int status = 200;         ///< of HTTP
  std::string_view why{};   ///< reason for people, if status is not 200
  std::string_view path{};  ///< part of the path after the token: "", "app.js", "socket"
};

/// Decides which requests are accepted. A page of a foreign site can make the user's browser send requests to
/// this machine. But it does not know the token, cannot hide its Origin, and is recognised by the Host if it
/// uses DNS rebinding.
class Gate {
 public:
  /// \param token  the first part of the path of addresses
  /// \param names  accepted host names, without a port
  Gate(std::string token, std::vector<std::string> names, std::uint16_t port);

  /// 405 another method than GET; 403 a Host that is not ours, or an Origin that is not the Host's (a socket
  /// must have one); 401 no token or a wrong one.
  [[nodiscard]] Verdict check(const Knock& knock) const;

 private:
  [[nodiscard]] bool is_our_host(std::string_view host) const;

  std::string token_;
  std::vector<std::string> names_;
  std::uint16_t port_;
};

/// 32 hexadecimal digits from the random numbers of the system.
std::string random_token();
/// Whether a text can be a token: 16 to 128 letters, digits, '-' and '_'.
bool is_token(std::string_view text);
/// Compares two texts in a time that does not depend on where they differ, so that a token cannot be guessed
/// letter by letter.
bool equal_in_constant_time(std::string_view a, std::string_view b);

}  // namespace palpate::view
