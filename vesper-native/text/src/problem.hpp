// SPDX-License-Identifier: Apache-2.0
// Problems of a law text, with their positions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vesper::text {

/// Part of a text, in bytes.
struct Span {
  uint32_t begin = 0;
  uint32_t end = 0;
};

/// Returns the smallest span that contains both.
inline Span Join(Span a, Span b) {
  return {a.begin < b.begin ? a.begin : b.begin, a.end > b.end ? a.end : b.end};
}

/// A position in a text, counted from 1; columns count characters.
struct Place {
  uint32_t line;
  uint32_t column;
};

Place PlaceOf(std::string_view text, uint32_t offset);

/// Returns "wind.law:5:15: " for the begin of a part of a text.
std::string Located(std::string_view source, std::string_view text, Span span);

/// Returns a part of a text in quotation marks, cut to 40 bytes.
std::string QuotedPart(std::string_view text, Span span);

/// A problem of a text, and how to correct it.
struct Problem {
  Span span;
  std::string message;  // what was found and what was expected
  std::string hint;     // what to do; may be empty
};

/// Thrown after a problem that prevents the reader from continuing in the same statement.
struct Abandon {};

/// The problems of one text, at most `kMost`, and one per line.
class Problems {
 public:
  static constexpr size_t kMost = 20;

  void Add(Span span, const std::string& message, const std::string& hint = {});
  /// Adds a problem and throws Abandon.
  [[noreturn]] void Fail(Span span, std::string message, std::string hint = {});
  bool empty() const { return problems_.empty(); }
  bool full() const { return problems_.size() >= kMost; }
  const std::vector<Problem>& list() const { return problems_; }

  /// Returns "wind.law:5:15: message; hint" of the first problem.
  std::string FirstLine(std::string_view source, std::string_view text) const;
  /// Returns all problems in the order of the text. Each problem has its line, a mark below the
  /// part concerned, and the hint.
  std::string Report(std::string_view source, std::string_view text) const;

 private:
  std::vector<Problem> problems_;
};

}  // namespace vesper::text
