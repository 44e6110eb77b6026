#include "view/gate.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <utility>

namespace palpate::view {
namespace {

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

Gate::Gate(std::string token, std::vector<std::string> names, std::uint16_t port)
    : token_(std::move(token)), names_(std::move(names)), port_(port) {}

bool Gate::is_our_host(std::string_view host) const {
  const std::string port = std::string(":").append(std::to_string(port_));
  if (!host.ends_with(port)) return false;
  host.remove_suffix(port.size());
  return std::ranges::any_of(names_,
                             [&](const std::string& name) { return equal_ignoring_case(host, name); });
}

Verdict Gate::check(const Knock& knock) const {
  if (!is_our_host(knock.host))
    return {403, "this host name is not allowed (add it with palpate view --name)"};
  const std::string origin = std::string("http://").append(knock.host);
  if (knock.origin ? !equal_ignoring_case(*knock.origin, origin) : knock.is_socket) {
    return {403, "requests from this origin are refused"};
  }
  if (knock.method != "GET") return {405, "only GET is answered"};
  std::string_view path = knock.target.substr(0, knock.target.find_first_of("?#"));
  if (!path.starts_with('/')) return {401, "the address needs the token that the command printed"};
  path.remove_prefix(1);
  const std::string_view token = path.substr(0, path.find('/'));
  if (!equal_in_constant_time(token, token_)) {
    return {401, "the address needs the token that the command printed"};
  }
  // Files are named relative to the folder of the token, so the path needs a slash after the token.
  if (path.size() == token.size()) return {404, "the address must end in a slash"};
  return {200, {}, path.substr(token.size() + 1)};
}

std::string random_token() {
  constexpr std::string_view digits = "0123456789abcdef";
  std::random_device random;  // libstdc++: the system's generator
  std::string token;
  for (int word = 0; word < 4; ++word) {
    auto bits = random();
    for (int digit = 0; digit < 8; ++digit, bits >>= 4) token += digits[bits & 15U];
  }
  return token;
}

bool is_token(std::string_view text) {
  constexpr std::size_t shortest = 16;
  constexpr std::size_t longest = 128;
  return text.size() >= shortest && text.size() <= longest && std::ranges::all_of(text, [](char c) {
           return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '-' ||
                  c == '_';
         });
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned>(static_cast<unsigned char>(b[i]));
  }
  return difference == 0;
}

}  // namespace palpate::view
