// SPDX-License-Identifier: Apache-2.0
// Expressions of a law text.
#pragma once

#include <string_view>
#include <vector>

#include "syntax.hpp"
#include "token.hpp"

namespace vesper::text {

/// The tokens of a text with a reading position. The last token is kEnd.
class TokenReader {
 public:
  TokenReader(std::string_view text, Problems& problems);

  const Token& Peek(size_t ahead = 0) const;
  Token Take();
  bool Takes(std::string_view word);
  /// Consumes the word or sign `word`. If the next token is different, reports the problem "found
  /// …, expected …".
  Token Expect(std::string_view word, std::string_view where);
  Name ExpectName(std::string_view what);
  [[noreturn]] void FailHere(const std::string& expected, std::string hint = {});
  bool AtLineEnd() const;
  /// Moves behind all tokens that begin before `offset`.
  void SkipTo(uint32_t offset);

  std::string_view text() const { return text_; }
  Problems& problems() { return problems_; }

 private:
  std::string_view text_;
  Problems& problems_;
  std::vector<Token> tokens_;
  size_t at_ = 0;
};

/// Parses one expression; reports a problem by throwing Abandon.
ExpressionTree ParseExpression(TokenReader& reader);

/// Parses the unit that begins at the next token, up to its end. Throws Abandon if there is none.
vesper_unit ParseUnitHere(TokenReader& reader, Span& span);

}  // namespace vesper::text
