// SPDX-License-Identifier: Apache-2.0
// A line of a scene, cut into words.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace vesper::cli {

/// A place in a text file; lines and columns count from 1.
struct Place {
  std::string file;
  int line = 1;
  int column = 1;
};

/// What is wrong in a scene; what() is "file:line:column: message".
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

/// Tokens of one line up to a comment, which is `#` at the start of a word and before a blank
/// or the end of the line. Throws SceneError for a quote or a unit without its end and for
/// control characters.
std::vector<Token> Tokenize(std::string_view line, Place place);

/// "1.5", "-2e3" or a fraction such as "1/240". False if `text` is no finite number.
bool ParseNumber(std::string_view text, double& out);

}  // namespace vesper::cli
