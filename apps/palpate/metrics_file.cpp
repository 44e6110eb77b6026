#include "metrics_file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <string_view>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <palpate/error.hpp>

#include "numbers.hpp"

namespace palpate::app {
namespace {

constexpr auto longest_wait = std::chrono::milliseconds(500);

/// A field of a CSV line (RFC 4180): in quotes where its text could be taken for more than one field.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

std::string header(const Units& units) {
  const auto in = [](const char* name, const std::string& unit) {
    return fmt::format(",{}", field(fmt::format("{} [{}]", name, unit)));
  };
  std::string line = "step" + in("time", units.time);
  for (const char* phase :
       {"grid", "contacts", "border_edges", "crossings", "depth", "forces", "solver", "step"}) {
    line += fmt::format(",wall_{} [s]", phase);
  }
  line +=
      ",contacts,border_edges,crossings,candidates,movers,depth_fallbacks,raised_depths,cancelled_directions,"
      "regions_without_border,border_edges_without_crossing,folded_pairs,approximated_primitives,"
      "dropped_cells,late_clusters,rough_depths,completeness,looks_ahead,sort,cuckoo_occupancy,cuckoo_"
      "retries,cuckoo_growths,detections,solves,solver_iterations,"
      "solver_converged,inverted_tets";
  line += in("kinetic_energy", energy_unit(units)) + in("elastic_energy", energy_unit(units));
  return line + in("largest_speed", speed_unit(units)) + in("fastest_body", speed_unit(units)) +
         in("deepest", units.length) + "\n";
}

}  // namespace

MetricsFile::MetricsFile(std::filesystem::path path, const Units& units)
    : path_(std::move(path)), lines_(header(units)) {
  open(O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
}

MetricsFile::MetricsFile(std::filesystem::path path, std::uint64_t bytes)
    : path_(std::move(path)), bytes_(bytes) {
  open(O_WRONLY | O_APPEND | O_CLOEXEC);
  const off_t size = ::lseek(descriptor_, 0, SEEK_END);
  if (size < 0 || static_cast<std::uint64_t>(size) < bytes) {
    ::close(std::exchange(descriptor_, -1));  // no destructor does it
    throw Error(path_.string(), "", std::to_string(size) + " bytes",
                std::to_string(bytes) + " or more, as when the checkpoint was written");
  }
  if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) {
    const int error = errno;
    ::close(std::exchange(descriptor_, -1));
    errno = error;
    fail("cutting off", "a file that can be written");
  }
}

void MetricsFile::open(int flags) {
  descriptor_ = ::open(path_.c_str(), flags, 0666);
  if (descriptor_ < 0) fail("opening", "a file that can be written");
}

void MetricsFile::fail(const char* doing, const char* expected) const {
  throw Error(path_.string(), doing, "'" + std::system_category().message(errno) + "'", expected);
}

MetricsFile::~MetricsFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void MetricsFile::add(const StepMetrics& m, double step_seconds) {
  lines_ += fmt::format("{},{}", m.step, exact_text(m.time));
  const DetectionTimes& t = m.detection_seconds;
  for (const double seconds : {t.grid, t.contacts, t.border_edges, t.crossings, t.depth, m.forces_seconds,
                               m.solver_seconds, step_seconds}) {
    lines_ += fmt::format(",{:.3e}", seconds);
  }
  const DetectionCounts& c = m.detection;
  const std::string_view sort = c.sort ? sort_names[static_cast<std::size_t>(*c.sort)] : "none";
  for (const std::size_t count :
       {c.contacts, c.border_edges, c.crossings, c.candidates, c.movers, c.depth_fallbacks, c.raised_depths,
        c.cancelled_directions, c.regions_without_border, c.border_edges_without_crossing, c.folded_pairs,
        c.approximated_primitives, c.dropped_cells}) {
    lines_ += fmt::format(",{}", count);
  }
  lines_ +=
      fmt::format(",{},{},{:.4f},{}", c.late_clusters, c.rough_depths, c.completeness, m.looks_ahead ? 1 : 0);
  const CuckooCounts points = c.cuckoo_points.value_or(CuckooCounts{});
  const CuckooCounts edges = c.cuckoo_edges.value_or(CuckooCounts{});
  lines_ += fmt::format(",{},{:.4f},{},{},{},{},{},{},{}", sort, points.occupancy(),
                        points.retries() + edges.retries(), points.growths + edges.growths, m.detections,
                        m.solves, m.solver_iterations, m.solver_converged ? 1 : 0, m.inverted_tets);
  for (const double value :
       {m.kinetic_energy, m.elastic_energy, m.largest_speed, m.fastest_body, m.deepest}) {
    lines_.append(1, ',').append(exact_text(value));
  }
  lines_ += '\n';
  if (std::chrono::steady_clock::now() - flushed_ > longest_wait) flush();
}

void MetricsFile::flush() {
  std::string_view left = lines_;
  while (!left.empty()) {
    const ssize_t written = ::write(descriptor_, left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("writing", "room for the whole file");
    left.remove_prefix(static_cast<std::size_t>(written));
    bytes_ += static_cast<std::uint64_t>(written);
  }
  // The system goes on writing to a file that has no name any more, and nobody would ever see it.
  struct stat status {};
  if (::fstat(descriptor_, &status) == 0 && status.st_nlink == 0)
    throw Error(path_.string(), "writing", "no such file: it was removed", "the file that the run began");
  lines_.clear();
  flushed_ = std::chrono::steady_clock::now();
}

void MetricsFile::sync() {
  flush();
  if (::fsync(descriptor_) != 0) fail("writing to the disk", "room for the whole file");
}

}  // namespace palpate::app
