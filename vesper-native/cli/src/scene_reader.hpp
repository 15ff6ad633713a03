// SPDX-License-Identifier: Apache-2.0
// Reader of a scene file, line by line and word by word.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "token.hpp"
#include "vesper/types.h"

namespace vesper::cli {

/// A number, or several in parentheses.
using Value = std::vector<double>;

class SceneReader {
 public:
  /// Stores `text`, the whole file, and `file`, its name in messages.
  SceneReader(std::string text, std::string file);

  /// Moves to the next line that contains words; returns false at the end of the file.
  bool NextLine();
  bool AtEnd() const { return next_ == tokens_.size(); }
  /// Returns the next word without taking it; empty at the end of the line.
  std::string Peek() const { return AtEnd() ? "" : tokens_[next_].text; }
  /// Returns true and takes the next word if it is `text`.
  bool Accept(const std::string& text);
  /// Takes the next word; if there is none, the error message contains `what`.
  std::string Word(const std::string& what);
  double Number(const std::string& what);
  /// Reads a number in the unit of UseUnit.
  double Quantity(const std::string& what);
  /// Reads an integer of at least `minimum`.
  uint64_t Count(const std::string& what, uint64_t minimum);
  /// Reads numbers in the unit of UseUnit.
  Value ReadValue(const std::string& what);
  /// Reads row numbers and ranges A..B as far as they go, all below `rows`.
  std::vector<uint64_t> RowNumbers(uint64_t rows, const std::string& kind);
  /// Sets the unit of the following quantities, which `what` names. A unit at the end of the line
  /// is converted to `unit`.
  void UseUnit(const vesper_unit& unit, const std::string& what);
  /// Throws if there is a unit at the end of the line.
  void RefuseUnit(const std::string& reason) const;
  void ExpectEnd();
  void Expect(const std::string& text);

  /// Returns the place of the next word, or of the end of the line.
  Place Here() const;
  /// Returns the place of the first word of the line.
  Place LineStart() const;
  /// Returns the place of the last word taken.
  Place Last() const;
  [[noreturn]] void FailLast(const std::string& message) const {
    throw SceneError(Last(), message);
  }
  /// Throws an error for the last word, which is not in `known`, and suggests the nearest name.
  [[noreturn]] void FailUnknown(const std::string& what,
                                const std::vector<std::string>& known) const;

 private:
  const Token& Take(const std::string& what);
  [[noreturn]] void FailUnit(const std::string& message) const;

  std::string text_;
  Place place_;
  size_t at_ = 0;  // offset of the next line
  size_t line_length_ = 0;
  std::vector<Token> tokens_;
  size_t next_ = 0;
  std::optional<Token> unit_;  // the unit at the end of the line
  bool unit_used_ = false;
  double scale_ = 1;  // factor for quantities
};

}  // namespace vesper::cli
