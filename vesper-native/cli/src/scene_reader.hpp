// SPDX-License-Identifier: Apache-2.0
// Goes through a scene file line by line and word by word.
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
  /// `text`: the whole file, `file` its name in messages.
  SceneReader(std::string text, std::string file);

  /// Goes to the next line that has words; false at the end of the file.
  bool NextLine();
  bool AtEnd() const { return next_ == tokens_.size(); }
  /// The next word, empty at the end of the line; leaves it there.
  std::string Peek() const { return AtEnd() ? "" : tokens_[next_].text; }
  /// Whether the next word is `text`; takes it if so.
  bool Accept(const std::string& text);
  /// The next word; `what` names it in the message if there is none.
  std::string Word(const std::string& what);
  double Number(const std::string& what);
  /// A number in the unit of UseUnit.
  double Quantity(const std::string& what);
  /// A whole number of at least `minimum`.
  uint64_t Count(const std::string& what, uint64_t minimum);
  /// Numbers in the unit of UseUnit.
  Value ReadValue(const std::string& what);
  /// Row numbers and ranges A..B up to where they end, all below `rows`.
  std::vector<uint64_t> RowNumbers(uint64_t rows, const std::string& kind);
  /// From here on quantities are those of `what`, kept in `unit`: if the line ends with a unit,
  /// they are converted from it.
  void UseUnit(const vesper_unit& unit, const std::string& what);
  /// Refuses a unit at the end of the line.
  void RefuseUnit(const std::string& reason) const;
  void ExpectEnd();
  void Expect(const std::string& text);

  /// Of the next word, or behind the last.
  Place Here() const;
  /// Of the first word of the line.
  Place LineStart() const;
  /// Of the word that was taken last.
  Place Last() const;
  [[noreturn]] void FailLast(const std::string& message) const {
    throw SceneError(Last(), message);
  }
  /// Refuses the last word, which is none of `known`; suggests the nearest of them.
  [[noreturn]] void FailUnknown(const std::string& what,
                                const std::vector<std::string>& known) const;

 private:
  const Token& Take(const std::string& what);
  [[noreturn]] void FailUnit(const std::string& message) const;

  std::string text_;
  Place place_;
  size_t at_ = 0;  // where the next line begins
  size_t line_length_ = 0;
  std::vector<Token> tokens_;
  size_t next_ = 0;
  std::optional<Token> unit_;  // at the end of the line
  bool unit_used_ = false;
  double scale_ = 1;  // of quantities
};

}  // namespace vesper::cli
