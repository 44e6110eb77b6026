#pragma once

#include <span>
#include <string_view>

namespace palpate::view {

/// A file of the page.
struct PageFile {
  std::string_view name;  ///< "index.html"
  std::string_view type;  ///< content type of HTTP
  std::string_view content;
};

/// The files of the page in this library; empty if npm was missing at build time.
std::span<const PageFile> page_files();

}  // namespace palpate::view
