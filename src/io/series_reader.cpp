#include "io/series_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "io/file_bytes.hpp"
#include "io/text_scanner.hpp"
#include "io/xml_scanner.hpp"

namespace palpate::io {
namespace {

namespace fs = std::filesystem;

std::string_view attribute(const XmlTag& tag, std::string_view name) {
  for (const auto& [key, value] : tag.attributes) {
    if (key == name) return value;
  }
  return {};
}

bool stays_inside(const fs::path& file) {
  return !file.empty() && file.is_relative() && std::ranges::find(file, fs::path("..")) == file.end();
}

SeriesFrame read_frame(const XmlScanner& xml, const XmlTag& tag, const fs::path& folder) {
  SeriesFrame frame;
  const std::string_view time = attribute(tag, "timestep");
  const auto [end, failed] = std::from_chars(time.data(), time.data() + time.size(), frame.time);
  if (failed != std::errc{} || end != time.data() + time.size() || !std::isfinite(frame.time)) {
    xml.fail(tag.begin, "timestep=" + in_quotes(time), "a finite number");
  }
  const fs::path file(attribute(tag, "file"));
  if (!stays_inside(file)) {
    xml.fail(tag.begin, "file=" + in_quotes(attribute(tag, "file")), "a path below the folder of this file");
  }
  frame.file = folder / file;
  return frame;
}

}  // namespace

std::vector<SeriesFrame> read_series(const fs::path& collection) {
  const std::string text = read_file(collection, "a ParaView collection (.pvd)");
  XmlScanner xml(collection.string(), text);
  XmlTag tag;
  std::vector<SeriesFrame> frames;
  bool is_collection = false;
  while (xml.next(tag)) {
    is_collection = is_collection || tag.name == "Collection";
    if (!tag.opens || tag.name != "DataSet") continue;
    const SeriesFrame frame = read_frame(xml, tag, collection.parent_path());
    if (!frames.empty() && frame.time <= frames.back().time) {
      xml.fail(tag.begin, "timestep=" + in_quotes(attribute(tag, "timestep")), "a later time than before");
    }
    frames.push_back(frame);
  }
  if (!is_collection) xml.fail(text.size(), "no Collection", "one");
  return frames;
}

}  // namespace palpate::io
