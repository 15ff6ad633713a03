// SPDX-License-Identifier: Apache-2.0
// Writes chosen properties frame by frame: a line per frame and row.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "scene.hpp"

namespace vesper::cli {

/// A file that cannot be written.
class FileError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "1.5", the shortest text that reads back as the same number of that type.
std::string FormatNumber(double number, vesper_scalar_type type);

/// "mass", or "position.x"; beyond four components "name.4".
std::string CsvColumnName(const vesper_property_descriptor& property, uint32_t component);

class CsvWriter {
 public:
  /// `columns`: of one kind, borrowed. Throws FileError if the file cannot be written.
  CsvWriter(const std::string& path, std::vector<const AnyColumn*> columns);

  void WriteFrame(uint64_t frame, double time);
  /// Throws FileError if something was not written.
  void Close();

 private:
  void Check() const;

  std::string path_;
  std::ofstream file_;
  std::vector<const AnyColumn*> columns_;
};

}  // namespace vesper::cli
