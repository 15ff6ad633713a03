// SPDX-License-Identifier: Apache-2.0
// Writer of selected properties of a run to a CSV file: one line per frame and row.
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

/// Returns the shortest text from which the same number of this type is read back, e.g. "1.5".
std::string FormatNumber(double number, vesper_scalar_type type);

/// Returns a column name such as "mass" or "position.x"; from the fifth component on, a number:
/// "name.4".
std::string CsvColumnName(const vesper_property_descriptor& property, uint32_t component);

class CsvWriter {
 public:
  /// Opens the file. `columns` must belong to one kind and outlive the writer. Throws FileError if
  /// the file cannot be written.
  CsvWriter(const std::string& path, std::vector<const AnyColumn*> columns);

  void WriteFrame(uint64_t frame, double time);
  /// Closes the file. Throws FileError if data could not be written.
  void Close();

 private:
  void Check() const;

  std::string path_;
  std::ofstream file_;
  std::vector<const AnyColumn*> columns_;
};

}  // namespace vesper::cli
