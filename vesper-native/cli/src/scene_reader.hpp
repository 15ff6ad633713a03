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
  /// Stores `text`, the whole file, and `file`, its name for messages.
  SceneReader(std::string text, std::string file);

  /// Moves to the next line that contains words; returns false at the end of the file.
  bool NextLine();
  bool AtEnd() const { return next_ == tokens_.size(); }
  /// Returns the next word without consuming it; empty at the end of the line.
  std::string Peek() const { return AtEnd() ? "" : tokens_[next_].text; }
  /// If the next word is `text`, consumes it and returns true.
  bool Accept(const std::string& text);
  /// Consumes and returns the next word; if there is none, throws an error whose message says that
  /// `what` was expected.
  std::string Word(const std::string& what);
  double Number(const std::string& what);
  /// Reads a number; converts it from the unit that UseUnit has found.
  double Quantity(const std::string& what);
  /// Reads an integer of at least `minimum`.
  uint64_t Count(const std::string& what, uint64_t minimum);
  /// Reads numbers; converts them from the unit that UseUnit has found.
  Value ReadValue(const std::string& what);
  /// Reads all following row numbers and ranges A..B; all numbers must be below `rows`.
  std::vector<uint64_t> RowNumbers(uint64_t rows, const std::string& kind);
  /// Sets the unit of the quantities in this line; `what` names them in messages. If the line ends
  /// with a different unit, quantities are converted from the line's unit to `unit`.
  void UseUnit(const vesper_unit& unit, const std::string& what);
  /// Throws if the line ends with a unit.
  void RefuseUnit(const std::string& reason) const;
  void ExpectEnd();
  void Expect(const std::string& text);

  /// Returns the position of the next word, or of the end of the line.
  Place Here() const;
  /// Returns the position of the first word of the line.
  Place LineStart() const;
  /// Returns the position of the last consumed word.
  Place Last() const;
  [[noreturn]] void FailLast(const std::string& message) const {
    throw SceneError(Last(), message);
  }
  /// Throws an error for the last consumed word, which is not in `known`; the message suggests the
  /// most similar name.
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
  std::optional<Token> unit_;  // the unit at the end of the line, such as [cm]
  bool unit_used_ = false;
  double scale_ = 1;  // factor from that unit to the unit of UseUnit
};

}  // namespace vesper::cli
