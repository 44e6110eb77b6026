#pragma once

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>
#include <string>

#include "view/sessions.hpp"

namespace palpate::view {

/// An open page: receives its commands, sends stage, states and frames.
class PageSession : public std::enable_shared_from_this<PageSession> {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  PageSession(boost::beast::tcp_stream stream, std::shared_ptr<Hub> hub);
  ~PageSession();
  PageSession(const PageSession&) = delete;
  PageSession& operator=(const PageSession&) = delete;

  void begin(Request request);
  /// Sends new messages to the page, one at a time.
  void send_news();
  void tell_refusal(const std::string& why);
  [[nodiscard]] const DisplayOptions& display() const { return display_; }

 private:
  void read();
  void take(std::string_view text);
  void send(std::shared_ptr<const std::string> message, bool binary);
  void leave();

  /// Maximum number of frames that are sent but not yet drawn: one being drawn, one on its way.
  static constexpr std::size_t max_in_flight = 2;

  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::beast::flat_buffer buffer_;
  Request request_;
  std::shared_ptr<Hub> hub_;
  Client client_;
  DisplayOptions display_;
  bool joined_ = false;
  bool sending_ = false;
  bool has_stage_ = false;
  std::uint64_t state_ = 0;                     ///< number of the last state sent
  std::uint64_t frame_ = 0;                     ///< number of the last frame sent
  std::deque<std::uint64_t> in_flight_;         ///< numbers of the frames sent but not drawn
  std::shared_ptr<const std::string> refusal_;  ///< the newest refusal that was not sent yet
};

}  // namespace palpate::view
