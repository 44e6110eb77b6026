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

/// A page of HTML that grows from top to bottom.
class HtmlPage {
 public:
  explicit HtmlPage(std::string_view title);
  void heading(std::string_view text);
  void paragraph(std::string_view text);
  /// A paragraph that stands out.
  void warning(std::string_view text);
  /// Rows of texts; the first is the head.
  void table(const std::vector<std::vector<std::string>>& rows);
  /// A PNG, as part of the page, with a line below it. Throws Error where it cannot be read.
  void picture(const std::filesystem::path& png, std::string_view caption);
  /// A text of several lines that is shown as it is when it is opened.
  void folded(std::string_view title, std::string_view text);
  [[nodiscard]] std::string take();

 private:
  std::string html_;
};

}  // namespace palpate::app
