#include "io/series_writer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <palpate/error.hpp>

#include "io/atomic_file.hpp"

namespace palpate::io {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view frames_folder = "frames";

std::string frame_name(std::size_t frame) {
  const std::string digits = std::to_string(frame);
  return "frame_" + std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".vtu";
}

bool is_frame_name(std::string_view name) {
  constexpr std::string_view head = "frame_";
  constexpr std::string_view tail = ".vtu";
  if (name.size() < head.size() + 6 + tail.size() || !name.starts_with(head) || !name.ends_with(tail))
    return false;
  name.remove_prefix(head.size());
  name.remove_suffix(tail.size());
  return std::ranges::all_of(name, [](char c) { return '0' <= c && c <= '9'; });
}

/// The shortest text that reads back as the same number.
std::string to_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

/// \param missing  frames to leave out, ascending
std::string collection_text(const std::vector<double>& times, const std::vector<std::size_t>& missing) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (std::size_t frame = 0; frame < times.size(); ++frame) {
    if (std::ranges::binary_search(missing, frame)) continue;
    text += "    <DataSet timestep=\"" + to_text(times[frame]) + "\" part=\"0\" file=\"" +
            std::string(frames_folder) + "/" + frame_name(frame) + "\"/>\n";
  }
  return text + "  </Collection>\n</VTKFile>\n";
}

/// A frame that cannot be removed is no error here: the error appears when a new frame replaces it.
void remove_frames(const fs::path& folder, std::size_t kept) {
  std::error_code ignored;
  std::set<std::string> stay;
  for (std::size_t frame = 0; frame < kept; ++frame) stay.insert(frame_name(frame));
  std::vector<fs::path> frames;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (is_frame_name(name) && !stay.contains(name)) frames.push_back(entry.path());
  }
  for (const fs::path& frame : frames) fs::remove(frame, ignored);
}

}  // namespace

SeriesWriter::SeriesWriter(fs::path folder, std::string name, std::vector<double> times)
    : folder_(std::move(folder)),
      collection_path_(folder_ / (std::move(name) + ".pvd")),
      times_(std::move(times)) {
  create_folder(folder_ / frames_folder);
  for (std::size_t frame = 0; frame < times_.size(); ++frame) {
    std::error_code ignored;
    if (!fs::is_regular_file(frame_path(frame), ignored)) missing_.push_back(frame);
  }
  // First the list, then the frames: so the collection never names a missing file.
  write_atomically(collection_path_, collection_text(times_, missing_));
  remove_frames(folder_ / frames_folder, times_.size());
}

fs::path SeriesWriter::frame_path(std::size_t frame) const {
  return folder_ / frames_folder / frame_name(frame);
}

void SeriesWriter::add(const Bodies& bodies, const FrameState& state) {
  write_frame(frame_path(times_.size()), bodies, state);
  list_frame(state.time);
}

void SeriesWriter::add(double time, VtuData data) {
  data.time = time;
  write_vtu(frame_path(times_.size()), data);
  list_frame(time);
}

void SeriesWriter::list_frame(double time) {
  times_.push_back(time);
  try {
    write_atomically(collection_path_, collection_text(times_, missing_));
  } catch (...) {
    times_.pop_back();
    throw;
  }
}

}  // namespace palpate::io
