#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

namespace palpate::app {

/// A field of a CSV line (RFC 4180): in quotes where its text could be taken for more than one field.
std::string csv_field(const std::string& text);

/// A CSV file that grows line by line as a run goes.
///
/// Lines reach the file at least each second of running and only as whole lines, so that a run that is killed
/// keeps what it did; a file that is removed meanwhile is an error.
class CsvFile {
 public:
  /// Starts the file anew, with this line, which has its line end. Throws Error naming the path if it cannot
  /// be written; so do the others.
  CsvFile(std::filesystem::path path, std::string header);
  /// Goes on with a file after its first so many bytes; what follows them is cut off. Throws Error where it
  /// has fewer.
  CsvFile(std::filesystem::path path, std::uint64_t bytes);
  ~CsvFile();
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;

  /// Adds a line, which has its line end.
  void add(const std::string& line);
  void flush();
  /// flush(), and waits until all lines are on the disk.
  void sync();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  ///< in the file

 private:
  void open(int flags);
  [[noreturn]] void fail(const char* doing, const char* expected) const;

  std::filesystem::path path_;
  std::string lines_;        ///< not yet in the file
  std::uint64_t bytes_ = 0;  ///< in the file
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  int descriptor_ = -1;
};

}  // namespace palpate::app
