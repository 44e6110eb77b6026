#include "view/server.hpp"

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <utility>

#include <palpate/error.hpp>

#include "view/sessions.hpp"

namespace palpate::view {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

tcp::acceptor listen(asio::io_context& context, const ServerSettings& settings) {
  if (!is_address(settings.host)) throw Error("view", "host", "'" + settings.host + "'", "an IP address");
  const auto address = asio::ip::make_address(settings.host);
  const std::string where = settings.host + ":" + std::to_string(settings.port);
  try {
    return {context, tcp::endpoint(address, settings.port)};
  } catch (const boost::system::system_error& error) {
    throw Error("view", "listening at " + where, "'" + error.code().message() + "'",
                "an address and port that are free");
  }
}

std::string in_address(const std::string& host) {
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

std::vector<std::string> host_names(const ServerSettings& settings) {
  std::vector<std::string> names{"localhost", "127.0.0.1", "[::1]", in_address(settings.host)};
  names.insert(names.end(), settings.names.begin(), settings.names.end());
  return names;
}

}  // namespace

bool is_address(const std::string& host) {
  boost::system::error_code failed;
  static_cast<void>(asio::ip::make_address(host, failed));
  return !failed;
}

struct Server::State {
  State(const ServerSettings& s, std::unique_ptr<Source> source, const PlayerSettings& playing)
      : settings(s),
        acceptor(listen(context, s)),
        hub(std::make_shared<Hub>(Gate(s.token, host_names(s), acceptor.local_endpoint().port()),
                                  std::make_unique<Player>(std::move(source), playing, [this] { tell(); }))) {
    accept();
  }
  ~State() { hub->player->stop(); }  // it notifies through `context`
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  /// Called in the thread of the player for news. Notifies once until the server has read them.
  void tell() {
    if (told.exchange(true)) return;
    asio::post(context, [this] {
      told = false;
      hub->spread();
    });
  }

  void accept() {
    acceptor.async_accept([this](boost::system::error_code failed, tcp::socket socket) {
      if (!failed) {
        boost::system::error_code ignored;
        socket.set_option(tcp::no_delay(true), ignored);
        begin_session(std::move(socket), hub);
      }
      if (failed != asio::error::operation_aborted) accept();
    });
  }

  ServerSettings settings;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  std::atomic<bool> told = false;
  std::shared_ptr<Hub> hub;
};

Server::Server(const ServerSettings& settings, std::unique_ptr<Source> source, const PlayerSettings& player)
    : state_(std::make_unique<State>(settings, std::move(source), player)) {}
Server::~Server() = default;

std::uint16_t Server::port() const {
  return state_->acceptor.local_endpoint().port();
}

std::string Server::address() const {
  return "http://" + in_address(state_->settings.host) + ":" + std::to_string(port()) + "/" +
         state_->settings.token + "/";
}

Player& Server::player() {
  return *state_->hub->player;
}

void Server::run_for(std::chrono::milliseconds time) {
  state_->context.run_for(time);
}

}  // namespace palpate::view
