// SPDX-License-Identifier: Apache-2.0
#include "csv.hpp"

#include <charconv>

namespace vesper::cli {
std::string CsvColumnName(const vesper_property_descriptor& property, uint32_t component) {
  if (property.components == 1) return property.name;
  const std::string suffix = property.components <= 4 && property.scalar_type <= VESPER_F64
                                 ? std::string(1, "xyzw"[component])
                                 : std::to_string(component);
  return std::string(property.name) + "." + suffix;
}

std::string FormatNumber(double number, vesper_scalar_type type) {
  char text[32];
  const auto end = type == VESPER_F32
                       ? std::to_chars(text, text + sizeof text, static_cast<float>(number)).ptr
                       : std::to_chars(text, text + sizeof text, number).ptr;
  return {text, end};
}

CsvWriter::CsvWriter(const std::string& path, std::vector<const AnyColumn*> columns)
    : path_(path), file_(path, std::ios::binary | std::ios::trunc), columns_(std::move(columns)) {
  file_ << "frame,time,row";
  for (const AnyColumn* column : columns_) {
    for (uint32_t c = 0; c < column->descriptor().components; ++c) {
      file_ << ',' << CsvColumnName(column->descriptor(), c);
    }
  }
  file_ << '\n';
  Check();
}

void CsvWriter::WriteFrame(uint64_t frame, double time) {
  const std::string start = std::to_string(frame) + ',' + FormatNumber(time, VESPER_F64) + ',';
  for (uint64_t row = 0; row < columns_[0]->rows(); ++row) {
    std::string line = start + std::to_string(row);
    for (const AnyColumn* column : columns_) {
      const auto& [n, type] =
          std::pair(column->descriptor().components, column->descriptor().scalar_type);
      for (uint32_t c = 0; c < n; ++c) line += ',' + FormatNumber(column->Get(row * n + c), type);
    }
    file_ << line << '\n';
  }
  Check();
}

void CsvWriter::Close() {
  file_.close();
  Check();
}

void CsvWriter::Check() const {
  if (!file_) throw FileError(path_ + ": cannot be written");
}

}  // namespace vesper::cli
