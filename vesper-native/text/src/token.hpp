// SPDX-License-Identifier: Apache-2.0
// Tokenizer of a law text: its words, numbers and signs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "problem.hpp"

namespace vesper::text {

enum class TokenKind { kName, kNumber, kText, kSign, kLineEnd, kIndent, kDedent, kEnd };

struct Token {
  TokenKind kind;
  Span span;
  std::string word;  // name, text or sign; Greek letters and typographic signs are converted to
                     // ASCII
  double number = 0;

  bool Is(std::string_view expected) const {
    return (kind == TokenKind::kSign || kind == TokenKind::kName) && word == expected;
  }
};

/// Splits a text into tokens. The tokens kIndent and kDedent mark blocks. A line that begins with
/// an operator continues the previous line, and so do lines inside brackets. Superscript digits
/// become the sign "^" and a number.
std::vector<Token> Tokens(std::string_view text, Problems& problems);

/// Describes a token for messages: "'force'", "the end of the line" and so on.
std::string Found(const Token& token);

}  // namespace vesper::text
