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

/// Data common to the sessions, which keep it alive.
struct Hub {
  Hub(Gate g, std::unique_ptr<Player> p) : gate(std::move(g)), player(std::move(p)) {}

  Gate gate;
  std::unique_ptr<Player> player;
  std::map<Client, PageSession*> pages;
  Client next_client = 1;
  std::size_t connections = 0;

  /// Largest number of connections; further ones are closed at once.
  static constexpr std::size_t most_connections = 64;

  /// Sends new messages to every page.
  void spread();
  /// Gives the player the union of the display options of all pages.
  void display();
};

/// Answers the request on a new connection: a file of the page, or a WebSocket.
void begin_session(boost::asio::ip::tcp::socket socket, std::shared_ptr<Hub> hub);

}  // namespace palpate::view
