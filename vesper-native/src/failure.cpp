// SPDX-License-Identifier: Apache-2.0
#include "failure.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string>

namespace vesper {
namespace {

void CopyCut(char* to, size_t capacity, std::string_view from) {
  const size_t length = std::min(from.size(), capacity - 1);
  std::memcpy(to, from.data(), length);
  std::memset(to + length, 0, capacity - length);
}

}  // namespace

vesper_error BlankError() {
  vesper_error error{};
  error.library_id = VESPER_NO_LIBRARY;
  error.law_index = VESPER_NO_LAW;
  error.row = VESPER_NO_ROW;
  return error;
}

Failure::Failure(vesper_status status, const char* format, ...) : error_(BlankError()) {
  error_.status = status;
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(error_.message, sizeof error_.message, format, arguments);
  va_end(arguments);
  Sanitize(error_);
}

Failure& Failure::Property(std::string_view name) {
  CopyCut(error_.property, sizeof error_.property, name);
  return *this;
}

Failure& Failure::Within(std::string_view context) {
  const std::string message = std::string(context) + ": " + error_.message;
  CopyCut(error_.message, sizeof error_.message, message);
  return *this;
}

void Sanitize(vesper_error& error) {
  error.message[sizeof error.message - 1] = '\0';
  error.property[sizeof error.property - 1] = '\0';
  for (char& c : error.message) {
    if (c == '\0') break;
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
}

}  // namespace vesper
