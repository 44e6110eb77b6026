#include "html_page.hpp"

#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <utility>

#include "io/file_bytes.hpp"

namespace palpate::app {
namespace {

constexpr std::string_view style =
    "body{font:15px/1.45 system-ui,sans-serif;max-width:72em;margin:2em auto;padding:0 1em;color:#1c1c1c}"
    "table{border-collapse:collapse;margin:.6em 0}td,th{border:1px solid #ccc;padding:.25em .6em;"
    "text-align:left;font-variant-numeric:tabular-nums}th{background:#f1f1f1}"
    ".warning{background:#fde8e4;border-left:4px solid #c0341d;padding:.4em .8em}"
    "figure{display:inline-block;margin:.4em .6em .4em 0;max-width:24em;vertical-align:top}"
    "img{max-width:100%}figcaption{font-size:13px;color:#555}pre{white-space:pre-wrap;font-size:12px}";

}  // namespace

std::string html_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? letters[three >> (18U - 6U * static_cast<unsigned>(k)) & 63U] : '=';
  }
  return text;
}

HtmlPage::HtmlPage(std::string_view title)
    : html_(fmt::format("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>"
                        "<style>{1}</style></head><body>\n<h1>{0}</h1>\n",
                        html_text(title), style)) {}

void HtmlPage::heading(std::string_view text) {
  html_ += fmt::format("<h2>{}</h2>\n", html_text(text));
}

void HtmlPage::paragraph(std::string_view text) {
  html_ += fmt::format("<p>{}</p>\n", html_text(text));
}

void HtmlPage::warning(std::string_view text) {
  html_ += fmt::format("<p class=\"warning\">{}</p>\n", html_text(text));
}

void HtmlPage::table(const std::vector<std::vector<std::string>>& rows) {
  html_ += "<table>\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    html_ += "<tr>";
    for (const std::string& cell : rows[r])
      html_ += fmt::format("<{0}>{1}</{0}>", r == 0 ? "th" : "td", html_text(cell));
    html_ += "</tr>\n";
  }
  html_ += "</table>\n";
}

void HtmlPage::picture(const std::filesystem::path& png, std::string_view caption) {
  const std::string image = base64(io::read_file(png, "a picture of the run"));
  html_ += fmt::format(
      "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
      html_text(caption), image);
}

void HtmlPage::folded(std::string_view title, std::string_view text) {
  html_ += fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n", html_text(title),
                       html_text(text));
}

std::string HtmlPage::take() {
  html_ += "</body></html>\n";
  return std::move(html_);
}

}  // namespace palpate::app
