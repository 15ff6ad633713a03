// SPDX-License-Identifier: Apache-2.0
// Tokenizer for the lines of a scene.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vesper::cli {

/// A position in a text file; lines and columns count from 1.
struct Place {
  std::string file;
  int line = 1;
  int column = 1;
};

/// An error in a scene; what() is "file:line:column: message".
class SceneError : public std::runtime_error {
 public:
  SceneError(const Place& place, const std::string& message)
      : std::runtime_error(place.file + ":" + std::to_string(place.line) + ":" +
                           std::to_string(place.column) + ": " + message) {}
};

/// A word, one of ( ) : =, a "quoted text" without its quotes, or a [unit] with its brackets.
struct Token {
  std::string text;
  int column;
  bool quoted = false;

  bool is_unit() const { return !quoted && text.starts_with('['); }
};

/// Returns the tokens of one line up to a comment. A comment begins with a `#` that stands alone:
/// at the start of a word, and before a blank or the end of the line. Throws SceneError for an
/// unterminated quote or unit and for control characters.
std::vector<Token> Tokenize(std::string_view line, Place place);

/// Parses "1.5", "-2e3" or a fraction such as "1/240". Returns false if `text` is not a finite
/// number.
bool ParseNumber(std::string_view text, double& out);

}  // namespace vesper::cli
