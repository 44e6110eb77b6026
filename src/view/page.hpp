#pragma once

#include <span>
#include <string_view>

namespace palpate::view {

/// A file of the page.
struct PageFile {
  std::string_view name;  ///< "index.html"
  std::string_view type;  ///< as HTTP says it
  std::string_view content;
};

/// The page as it was built into this library; empty where npm was missing then.
std::span<const PageFile> page_files();

}  // namespace palpate::view
