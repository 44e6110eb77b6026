#include "io/xml_scanner.hpp"

#include <algorithm>
#include <fmt/format.h>

#include <palpate/error.hpp>

#include "io/text_scanner.hpp"

namespace palpate::io {
namespace {

constexpr std::string_view blanks = " \t\r\n";

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
         c == ':' || c == '.';
}

}  // namespace

bool is_xml(std::string_view text) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  const std::size_t first = text.find_first_not_of(blanks);
  return first != std::string_view::npos && text[first] == '<';
}

void XmlScanner::fail(std::size_t position, const std::string& found, const std::string& expected) const {
  const auto begin = text_.begin();
  const auto end = begin + static_cast<std::ptrdiff_t>(std::min(position, text_.size()));
  throw Error(source_, fmt::format("line {}", 1 + std::count(begin, end, '\n')), found, expected);
}

char XmlScanner::current() const {
  if (position_ >= text_.size()) fail(position_, "the end of the file inside a tag", "the tag's end");
  return text_[position_];
}

void XmlScanner::skip_blanks() {
  position_ = std::min(text_.find_first_not_of(blanks, position_), text_.size());
}

/// Advances to the next '<' of a tag; false at the end of the text.
bool XmlScanner::find_tag() {
  while (true) {
    const std::size_t found = text_.find('<', position_);
    if (open_.empty()) {
      const std::string_view between =
          text_.substr(position_, found == std::string_view::npos ? found : found - position_);
      const std::size_t stray = between.find_first_not_of(blanks);
      if (stray != std::string_view::npos) {
        fail(position_ + stray, in_quotes(between.substr(stray)),
             had_root_ ? "the end of the file" : "an XML tag");
      }
    }
    position_ = std::min(found, text_.size());
    if (found == std::string_view::npos) return false;
    std::string_view end;
    if (text_.substr(found).starts_with("<!--")) end = "-->";
    if (text_.substr(found).starts_with("<?")) end = "?>";
    if (end.empty()) return true;
    const std::size_t closed = text_.find(end, found);
    if (closed == std::string_view::npos)
      fail(found, "the end of the file inside a comment", std::string(end));
    position_ = closed + end.size();
  }
}

bool XmlScanner::next(XmlTag& tag) {
  if (!find_tag()) {
    if (!open_.empty()) fail(text_.size(), "the end of the file", fmt::format("</{}>", open_.back()));
    if (!had_root_) fail(text_.size(), "the end of the file", "an XML tag");
    return false;
  }
  tag = XmlTag{};
  tag.begin = position_++;
  tag.closes = current() == '/';
  tag.opens = !tag.closes;
  if (tag.closes) ++position_;
  read_name(tag);
  for (skip_blanks(); current() != '>' && current() != '/'; skip_blanks()) read_attribute(tag);
  if (current() == '/') {
    if (!tag.opens) fail(position_, "\"/\" in an end tag", "\">\"");
    tag.closes = true;
    ++position_;
    if (current() != '>') fail(position_, in_quotes(text_.substr(position_, 1)), "\">\"");
  }
  tag.end = ++position_;
  match(tag);
  return true;
}

void XmlScanner::read_name(XmlTag& tag) {
  const std::size_t begin = position_;
  while (is_name_character(current())) ++position_;
  tag.name = text_.substr(begin, position_ - begin);
  if (tag.name.empty()) fail(begin, in_quotes(text_.substr(begin, 1)), "the name of a tag");
}

void XmlScanner::read_attribute(XmlTag& tag) {
  const std::size_t begin = position_;
  while (is_name_character(current())) ++position_;
  const std::string_view name = text_.substr(begin, position_ - begin);
  if (name.empty()) fail(begin, in_quotes(text_.substr(begin, 1)), "the name of an attribute");
  skip_blanks();
  if (current() != '=')
    fail(position_, in_quotes(text_.substr(position_, 1)), fmt::format("\"=\" after {}", name));
  ++position_;
  skip_blanks();
  const char quote = current();
  if (quote != '"' && quote != '\'')
    fail(position_, in_quotes(text_.substr(position_, 1)), "a value in quotes");
  const std::size_t end = text_.find_first_of(quote == '"' ? "\"<" : "'<", ++position_);
  if (end == std::string_view::npos || text_[end] == '<') {
    fail(position_, fmt::format("a value of {} without its closing quote", name), "the quote");
  }
  tag.attributes.emplace_back(name, text_.substr(position_, end - position_));
  position_ = end + 1;
}

void XmlScanner::match(const XmlTag& tag) {
  if (tag.opens) {
    if (open_.empty() && had_root_) fail(tag.begin, in_quotes(tag.name), "one root element");
    had_root_ = true;
    open_.push_back(tag.name);
  }
  if (!tag.closes) return;
  if (open_.empty() || open_.back() != tag.name) {
    fail(tag.begin, fmt::format("</{}>", tag.name),
         open_.empty() ? "no end tag" : fmt::format("</{}>", open_.back()));
  }
  open_.pop_back();
}

}  // namespace palpate::io
