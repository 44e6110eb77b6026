#include "view/sessions.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "view/page.hpp"
#include "view/page_session.hpp"

namespace palpate::view {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::uint32_t longest_header = 8192;
constexpr std::chrono::seconds longest_wait(10);

/// The value of a header that must not be repeated.
std::optional<std::string_view> single(const http::request<http::empty_body>& request, http::field field) {
  const auto [first, last] = request.equal_range(field);
  if (first == last || std::next(first) != last) return std::nullopt;
  const auto value = first->value();
  return std::string_view(value.data(), value.size());
}

/// Whether the error is malformed HTTP; other errors are a closed connection or a timeout.
bool is_malformed(const beast::error_code& failed) {
  const beast::error_code end = http::error::end_of_stream;
  return failed != end && failed.category() == end.category();
}

/// One request and its answer.
class Exchange : public std::enable_shared_from_this<Exchange> {
 public:
  Exchange(boost::asio::ip::tcp::socket socket, std::shared_ptr<Hub> hub)
      : stream_(std::move(socket)), hub_(std::move(hub)) {
    ++hub_->connections;
    parser_.header_limit(longest_header);
    parser_.body_limit(0);
  }
  ~Exchange() { --hub_->connections; }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  void begin() {
    stream_.expires_after(longest_wait);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](beast::error_code failed, std::size_t) {
                       if (!failed) return self->answer();
                       if (is_malformed(failed)) {
                         self->send(400, "text/plain", "malformed request\n");
                       }
                     });
  }

 private:
  void answer() {
    const auto& request = parser_.get();
    const bool is_socket = beast::websocket::is_upgrade(request);
    const bool many_origins = request.count(http::field::origin) > 1;
    const auto text = [](beast::string_view s) { return std::string_view(s.data(), s.size()); };
    const Verdict verdict = hub_->gate.check(
        {text(request.method_string()), text(request.target()),
         single(request, http::field::host).value_or(""),
         many_origins ? std::optional<std::string_view>("several") : single(request, http::field::origin),
         is_socket});
    if (verdict.status != 200) return send(verdict.status, "text/plain", std::string(verdict.why) + "\n");
    if (verdict.path == "socket" && is_socket) {
      std::make_shared<PageSession>(std::move(stream_), hub_)->begin(parser_.release());
      return;
    }
    if (verdict.path == "status") return send(200, "application/json", hub_->player->status() + "\n");
    const std::string_view name = verdict.path.empty() ? "index.html" : verdict.path;
    for (const PageFile& file : page_files()) {  // a table, not the file system: paths cannot leave a folder
      if (file.name == name) return send(200, file.type, std::string(file.content));
    }
    send(404, "text/plain", "not found\n");
  }

  void send(int status, std::string_view type, std::string body) {
    response_.result(static_cast<unsigned>(status));
    response_.version(11);
    response_.keep_alive(false);
    response_.set(http::field::content_type, beast::string_view(type.data(), type.size()));
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    response_.set("Cross-Origin-Resource-Policy", "same-origin");
    response_.set(
        "Content-Security-Policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' "
        "data: blob:; media-src blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
    response_.body() = std::move(body);
    response_.prepare_payload();
    http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code, std::size_t) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
    });
  }

  beast::tcp_stream stream_;
  std::shared_ptr<Hub> hub_;
  beast::flat_buffer buffer_{longest_header};
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

void Hub::spread() {
  for (const Refusal& refusal : player->pop_refusals()) {
    const auto page = pages.find(refusal.client);
    if (page != pages.end()) page->second->tell_refusal(refusal.why);
  }
  for (const auto& [client, page] : pages) page->send_news();
}

void Hub::display() {
  DisplayOptions all;
  for (const auto& [client, page] : pages) {
    all.contacts = all.contacts || page->display().contacts;
    all.borders = all.borders || page->display().borders;
    all.cells = all.cells || page->display().cells;
    all.inside = all.inside || page->display().inside;
    all.forces = all.forces || page->display().forces;
    for (const std::string& name : page->display().fields) {
      if (std::ranges::find(all.fields, name) == all.fields.end()) all.fields.push_back(name);
    }
  }
  player->display(all);
}

void begin_session(boost::asio::ip::tcp::socket socket, std::shared_ptr<Hub> hub) {
  if (hub->connections < Hub::most_connections)
    std::make_shared<Exchange>(std::move(socket), std::move(hub))->begin();
}

}  // namespace palpate::view
