#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace palpate::io {

/// A start tag, end tag or empty tag of an XML file. Views into the file's text.
struct XmlTag {
  std::string_view name;
  std::vector<std::pair<std::string_view, std::string_view>>
      attributes;         ///< (name, value without its quotes)
  bool opens = false;     ///< <name> or <name/>
  bool closes = false;    ///< </name> or <name/>
  std::size_t begin = 0;  ///< offset of '<'
  std::size_t end = 0;    ///< offset behind '>'
};

/// Whether a text begins like an XML file, after blanks and a byte order mark.
bool is_xml(std::string_view text);

/// Walks the tags of an XML file in order and checks that they nest; entities in values are not decoded.
///
/// Callers read the text between tags themselves: from the `end` of one to the `begin` of the next.
/// Declarations, processing instructions and comments are skipped. Throws Error naming the line for tags that
/// are cut off, malformed, or do not match.
class XmlScanner {
 public:
  /// \param text  the whole file, not copied
  XmlScanner(std::string source, std::string_view text) : source_(std::move(source)), text_(text) {}

  /// Reads the next tag; false after the end of the root element, if only blanks and comments follow.
  bool next(XmlTag& tag);
  /// Continues after that byte, for content that is not XML.
  void set_position(std::size_t position) { position_ = position; }
  /// Throws Error at the line of a byte.
  [[noreturn]] void fail(std::size_t position, const std::string& found, const std::string& expected) const;

 private:
  bool find_tag();
  void read_name(XmlTag& tag);
  void read_attribute(XmlTag& tag);
  void match(const XmlTag& tag);
  void skip_blanks();
  [[nodiscard]] char current() const;

  std::string source_;
  std::string_view text_;
  std::size_t position_ = 0;
  std::vector<std::string_view> open_;
  bool had_root_ = false;
};

}  // namespace palpate::io
