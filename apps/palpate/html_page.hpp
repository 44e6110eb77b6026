#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::app {

/// Text for HTML: &, <, > and " as entities.
std::string html_text(std::string_view text);

/// Bytes in base64 (RFC 4648).
std::string base64(std::string_view bytes);

/// Builds an HTML page from top to bottom.
class HtmlPage {
 public:
  explicit HtmlPage(std::string_view title);
  void heading(std::string_view text);
  void paragraph(std::string_view text);
  /// A highlighted paragraph.
  void warning(std::string_view text);
  /// A table of rows of text; the first row is the header.
  void table(const std::vector<std::vector<std::string>>& rows);
  /// A PNG embedded in the page, with a caption. Throws Error if it cannot be read.
  void picture(const std::filesystem::path& png, std::string_view caption);
  /// Preformatted text in a section that the reader can unfold.
  void folded(std::string_view title, std::string_view text);
  [[nodiscard]] std::string take();

 private:
  std::string html_;
};

}  // namespace palpate::app
