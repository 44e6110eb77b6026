#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "view/gate.hpp"
#include "view/player.hpp"

/// The parts of the server that use HTTP and WebSockets (Boost.Beast). All run in the thread of the server.
namespace palpate::view {

class PageSession;

/// Common to the sessions, which keep it alive.
struct Hub {
  Hub(Gate g, std::unique_ptr<Player> p) : gate(std::move(g)), player(std::move(p)) {}

  Gate gate;
  std::unique_ptr<Player> player;
  std::map<Client, PageSession*> pages;
  Client next_client = 1;
  std::size_t connections = 0;

  /// Connections at a time; more are closed at once.
  static constexpr std::size_t most_connections = 64;

  /// Sends every page what is new to it.
  void spread();
  /// Gives the player the union of the display options of all pages.
  void display();
};

/// Answers the request on a new connection: a file of the page, or a WebSocket.
void begin_session(boost::asio::ip::tcp::socket socket, std::shared_ptr<Hub> hub);

}  // namespace palpate::view
