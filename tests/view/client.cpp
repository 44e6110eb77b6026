#include "view/client.hpp"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <stdexcept>

#include "view/messages.hpp"

namespace palpate::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;

tcp::endpoint here(std::uint16_t port) {
  return {asio::ip::address_v4::loopback(), port};
}

std::string kind_of(const Socket::Received& received) {
  const auto json =
      received.binary ? read_message(received.data).header : nlohmann::json::parse(received.data);
  return json.at("kind");
}

}  // namespace

Answer ask_raw(std::uint16_t port, const std::string& request) {
  asio::io_context context;
  tcp::socket socket(context);
  socket.connect(here(port));
  boost::system::error_code failed;
  asio::write(socket, asio::buffer(request), failed);
  std::string text;
  asio::read(socket, asio::dynamic_buffer(text), failed);
  if (!text.starts_with("HTTP/1.")) return {};
  const std::size_t body = text.find("\r\n\r\n");
  return {std::stoi(text.substr(9, 3)), body == std::string::npos ? "" : text.substr(body + 4)};
}

Answer get(std::uint16_t port, const std::string& target, const std::string& headers) {
  return ask_raw(port, "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" +
                           headers + "\r\n");
}

struct Socket::State {
  asio::io_context context;
  beast::websocket::stream<tcp::socket> stream{context};
};

Socket::Socket(std::uint16_t port, const std::string& target) : state_(std::make_unique<State>()) {
  const std::string host = "127.0.0.1:" + std::to_string(port);
  auto& stream = state_->stream;
  beast::get_lowest_layer(stream).connect(here(port));
  stream.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
    request.set(beast::http::field::origin, "http://" + host);
  }));
  stream.read_message_max(std::size_t{1} << 30);
  stream.handshake(host, target);
}

Socket::~Socket() = default;

bool Socket::send(const std::string& text, bool binary) {
  state_->stream.binary(binary);
  boost::system::error_code failed;
  state_->stream.write(asio::buffer(text), failed);
  return !failed;
}

std::optional<Socket::Received> Socket::receive() {
  beast::flat_buffer buffer;
  boost::system::error_code failed;
  state_->stream.read(buffer, failed);
  if (failed) return std::nullopt;
  return Received{state_->stream.got_binary(), beast::buffers_to_string(buffer.cdata())};
}

Socket::Received Socket::receive_kind(const std::string& kind) {
  while (true) {
    const std::optional<Received> received = receive();
    if (!received) throw std::runtime_error("the server closed the connection before a " + kind);
    if (kind_of(*received) == kind) return *received;
  }
}

int Socket::close_code() const {
  return state_->stream.reason().code;
}

}  // namespace palpate::test
