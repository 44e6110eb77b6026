#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

namespace palpate::app {

/// A field of a CSV line (RFC 4180): in quotes where its text contains a separator, a quote or a line end.
std::string csv_field(const std::string& text);

/// A CSV file that grows line by line during a run.
///
/// Lines reach the file at least once a second, and only as whole lines. So a run that is killed keeps its
/// results. If the file is removed during the run, that is an error.
class CsvFile {
 public:
  /// Creates or replaces the file, with this first line, which includes its line end. All functions throw
  /// Error naming the path if it cannot be written.
  CsvFile(std::filesystem::path path, std::string header);
  /// Appends to a file after its first `bytes` bytes; the rest is cut off. Throws Error if the file is
  /// shorter.
  CsvFile(std::filesystem::path path, std::uint64_t bytes);
  ~CsvFile();
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  /// Adds a line, which includes its line end.
  void add(const std::string& line);
  void flush();
  /// flush(), and waits until all lines are on the disk.
  void sync();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  ///< in the file

 private:
  void open(int flags);
  [[noreturn]] void fail(const char* doing, const char* expected) const;

  std::filesystem::path path_;
  std::string lines_;        ///< not yet written
  std::uint64_t bytes_ = 0;  ///< in the file
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  int descriptor_ = -1;
};

}  // namespace palpate::app
