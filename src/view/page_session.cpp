#include "view/page_session.hpp"

#include <utility>
#include <variant>

#include <palpate/error.hpp>

namespace palpate::view {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

}  // namespace

PageSession::PageSession(beast::tcp_stream stream, std::shared_ptr<Hub> hub)
    : socket_(std::move(stream)), hub_(std::move(hub)), client_(hub_->next_client++) {
  ++hub_->connections;
}

PageSession::~PageSession() {
  leave();
  --hub_->connections;
}

void PageSession::leave() {
  if (!std::exchange(joined_, false)) return;
  hub_->pages.erase(client_);
  hub_->player->leave(client_);
  hub_->display();
}

void PageSession::begin(Request request) {
  request_ = std::move(request);
  beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has its own timeout
  socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  socket_.read_message_max(longest_message);
  socket_.async_accept(request_, [self = shared_from_this()](beast::error_code failed) {
    if (failed) return;
    self->joined_ = true;
    self->hub_->pages[self->client_] = self.get();
    self->hub_->player->join(self->client_);
    self->read();
    self->send_news();
  });
}

void PageSession::read() {
  socket_.async_read(buffer_, [self = shared_from_this()](beast::error_code failed, std::size_t) {
    if (failed) {  // closed, or the message is too long
      self->leave();
      return;
    }
    if (self->socket_.got_text()) {
      self->take(beast::buffers_to_string(self->buffer_.cdata()));
    } else {
      self->tell_refusal("message from the page: found bytes, expected text");
    }
    self->buffer_.clear();
    self->read();
  });
}

void PageSession::take(std::string_view text) {
  try {
    Command command = parse_command(text);
    if (const DisplayOptions* display = std::get_if<DisplayOptions>(&command)) {
      display_ = *display;
      hub_->display();
    } else if (const Shown* shown = std::get_if<Shown>(&command)) {
      // The page has skipped earlier frames.
      std::erase_if(in_flight_,
                    [&](std::uint64_t frame) { return static_cast<double>(frame) <= shown->frame; });
      send_news();
    } else if (!hub_->player->post(client_, std::move(command))) {
      tell_refusal("too many commands at once");
    }
  } catch (const Error& error) {
    tell_refusal(error.what());
  }
}

void PageSession::tell_refusal(const std::string& why) {
  const nlohmann::ordered_json json{{"kind", "refusal"}, {"why", why}};
  refusal_ = std::make_shared<const std::string>(
      json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  send_news();
}

void PageSession::send_news() {
  if (sending_ || !joined_) return;
  if (!std::exchange(has_stage_, true)) return send(hub_->player->stage(), true);
  if (refusal_) return send(std::exchange(refusal_, nullptr), false);
  const News news = hub_->player->news();
  if (news.state_number > state_) {
    state_ = news.state_number;
    return send(news.state, false);
  }
  if (in_flight_.size() >= max_in_flight) return;
  if (news.frame_number > frame_) {
    frame_ = news.frame_number;
    in_flight_.push_back(frame_);
    return send(news.frame, true);
  }
  hub_->player->want_frame();
}

void PageSession::send(std::shared_ptr<const std::string> message, bool binary) {
  sending_ = true;
  socket_.binary(binary);
  const auto bytes = boost::asio::buffer(*message);
  socket_.async_write(bytes, [self = shared_from_this(), message = std::move(message)](
                                 beast::error_code failed, std::size_t) {
    self->sending_ = false;
    if (!failed) self->send_news();
  });
}

}  // namespace palpate::view
