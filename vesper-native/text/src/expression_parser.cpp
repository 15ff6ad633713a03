// SPDX-License-Identifier: Apache-2.0
#include "expression_parser.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

#include "unit_parser.hpp"

namespace vesper::text {
namespace {

constexpr int kMaxExpressionDepth = 64;
constexpr int kMaxParts = 600;
constexpr int kMaxUnitDepth = 16;  // maximum nesting of brackets in a unit, as in unit_parser.cpp

// Non-ASCII letters that are units.
constexpr std::string_view kUnitLetters[] = {"\u00b0", "\u03a9", "\u00b5", "\u03bc"};
constexpr std::string_view kTimes[] = {"*", "·", "⋅"};
constexpr std::string_view kRaisedSigns[] = {"⁻", "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
// Words of the language that could also be read as units.
constexpr std::string_view kBuiltIn[] = {"dt", "pi", "time", "stage"};

bool IsUnit(std::string_view symbol) {
  try {
    ParseUnitOrThrowWhere(symbol);
    return true;
  } catch (const UnitError&) {
    return false;
  }
}

/// Finds the longest unit at a position of a text: symbols with exponents, joined without spaces.
class UnitScanner {
 public:
  UnitScanner(std::string_view text, size_t at, int depth = 0)
      : text_(text), at_(at), depth_(depth) {}

  /// Returns the position after the unit. Returns the start position if there is no unit.
  size_t Run() {
    if (!Term()) return at_;
    while (true) {
      const size_t before = at_;
      if (!Take("/") && !std::any_of(std::begin(kTimes), std::end(kTimes),
                                     [&](auto sign) { return Take(sign); })) {
        return at_;
      }
      if (Term() || Bracket()) continue;
      at_ = before;
      return at_;
    }
  }
  const std::vector<std::string>& symbols() const { return symbols_; }

 private:
  bool Take(std::string_view word) {
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  char Here() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  bool Term() {
    const size_t begin = at_;
    while (Letter()) {
    }
    const std::string_view symbol = text_.substr(begin, at_ - begin);
    const bool is_word = Here() == '_' || std::isdigit(static_cast<unsigned char>(Here())) != 0;
    const bool is_call = Here() == '(' && IsFunction(symbol);
    const bool is_member = Here() == '.' && at_ + 1 < text_.size() &&
                           std::isalpha(static_cast<unsigned char>(text_[at_ + 1])) != 0;
    if (symbol.empty() || is_word || is_call || is_member || IsReserved(symbol) ||
        std::find(std::begin(kBuiltIn), std::end(kBuiltIn), symbol) != std::end(kBuiltIn) ||
        !IsUnit(symbol)) {
      at_ = begin;
      return false;
    }
    symbols_.emplace_back(symbol);
    Exponent();
    return true;
  }

  bool Letter() {
    if (std::isalpha(static_cast<unsigned char>(Here())) != 0 || Here() == '%') {
      ++at_;
      return true;
    }
    return std::any_of(std::begin(kUnitLetters), std::end(kUnitLetters),
                       [&](auto letter) { return Take(letter); });
  }

  void Exponent() {
    const size_t begin = at_;
    if (Take("^")) {
      Take("-");
      if (std::isdigit(static_cast<unsigned char>(Here())) == 0) {
        at_ = begin;
        return;
      }
      while (std::isdigit(static_cast<unsigned char>(Here())) != 0) ++at_;
      return;
    }
    while (std::any_of(std::begin(kRaisedSigns), std::end(kRaisedSigns),
                       [&](auto sign) { return Take(sign); })) {
    }
  }

  bool Bracket() {
    const size_t begin = at_;
    if (depth_ == kMaxUnitDepth || !Take("(")) return false;
    const size_t inside = at_;
    UnitScanner scanner(text_, inside, depth_ + 1);
    at_ = scanner.Run();
    if (at_ == inside || !Take(")")) {
      at_ = begin;
      return false;
    }
    symbols_.insert(symbols_.end(), scanner.symbols().begin(), scanner.symbols().end());
    return true;
  }

  std::string_view text_;
  size_t at_;
  int depth_;
  std::vector<std::string> symbols_;
};

class ExpressionParser {
 public:
  explicit ExpressionParser(TokenReader& reader) : reader_(reader) {}

  ExpressionTree Conditional() {
    const Depth depth(*this);
    ExpressionTree value = Or();
    if (!reader_.Peek().Is("if")) return value;
    reader_.Take();
    ExpressionTree condition = Or();
    if (!reader_.Peek().Is("else")) {
      reader_.FailHere("'else'", "write VALUE if CONDITION else VALUE");
    }
    reader_.Take();
    ExpressionTree otherwise = Conditional();
    ExpressionTree all = Make(ExpressionKind::kConditional, Join(value->span, otherwise->span));
    all->parts.push_back(std::move(value));
    all->parts.push_back(std::move(condition));
    all->parts.push_back(std::move(otherwise));
    return all;
  }

 private:
  /// Counts nested calls of the parser, to limit the recursion.
  struct Depth {
    explicit Depth(ExpressionParser& parser) : parser_(parser) {
      if (++parser_.depth_ > kMaxExpressionDepth) {
        parser_.reader_.problems().Fail(parser_.reader_.Peek().span,
                                        "the expression is nested more than 64 deep",
                                        "name parts of it with let");
      }
    }
    ~Depth() { --parser_.depth_; }
    ExpressionParser& parser_;
  };

  ExpressionTree Make(ExpressionKind kind, Span span) {
    if (++parts_ > kMaxParts) {
      reader_.problems().Fail(span, "the expression has more than 600 parts",
                              "name parts of it with let");
    }
    auto tree = std::make_unique<Expression>();
    tree->kind = kind;
    tree->span = span;
    return tree;
  }

  ExpressionTree Binary(std::string word, ExpressionTree left, ExpressionTree right) {
    ExpressionTree tree = Make(ExpressionKind::kBinary, Join(left->span, right->span));
    tree->word = std::move(word);
    tree->parts.push_back(std::move(left));
    tree->parts.push_back(std::move(right));
    return tree;
  }

  ExpressionTree Or() {
    ExpressionTree left = And();
    while (reader_.Peek().Is("or") || reader_.Peek().Is("||")) {
      Spelled("||", "or");
      left = Binary("or", std::move(left), And());
    }
    return left;
  }

  ExpressionTree And() {
    ExpressionTree left = Not();
    while (reader_.Peek().Is("and") || reader_.Peek().Is("&&")) {
      Spelled("&&", "and");
      left = Binary("and", std::move(left), Not());
    }
    return left;
  }

  /// Consumes an operator. Reports a problem with a hint at `ours` if the operator has the spelling
  /// `foreign` of other languages.
  void Spelled(std::string_view foreign, std::string_view ours) {
    const Token token = reader_.Take();
    if (token.word != foreign) return;
    reader_.problems().Fail(token.span, "'" + token.word + "' has no meaning in a law",
                            "write " + std::string(ours));
  }

  ExpressionTree Not() {
    const Depth depth(*this);
    if (!reader_.Peek().Is("not") && !reader_.Peek().Is("!")) return Comparison();
    const Span begin = reader_.Peek().span;
    Spelled("!", "not");
    ExpressionTree inner = Not();
    ExpressionTree tree = Make(ExpressionKind::kNot, Join(begin, inner->span));
    tree->parts.push_back(std::move(inner));
    return tree;
  }

  static bool IsComparison(const Token& token) {
    return token.Is("<") || token.Is(">") || token.Is("<=") || token.Is(">=") || token.Is("=") ||
           token.Is("==") || token.Is("!=");
  }

  ExpressionTree Comparison() {
    ExpressionTree left = Sum();
    ExpressionTree all;
    while (IsComparison(reader_.Peek())) {
      std::string word = reader_.Take().word;
      if (word == "==") word = "=";
      ExpressionTree right = Sum();
      ExpressionTree next;
      if (IsComparison(reader_.Peek())) {  // a < b < c uses the middle operand twice
        ExpressionTree copy = Copy(*right);
        next = Binary(word, std::move(left), std::move(right));
        left = std::move(copy);
      } else {
        next = Binary(word, std::move(left), std::move(right));
      }
      all = all == nullptr ? std::move(next) : Binary("and", std::move(all), std::move(next));
      if (left == nullptr) break;
    }
    return all == nullptr ? std::move(left) : std::move(all);
  }

  ExpressionTree Copy(const Expression& from) {
    ExpressionTree copy = Make(from.kind, from.span);
    copy->word = from.word;
    copy->number = from.number;
    copy->unit = from.unit;
    copy->unit_symbols = from.unit_symbols;
    for (const ExpressionTree& part : from.parts) copy->parts.push_back(Copy(*part));
    return copy;
  }

  ExpressionTree Sum() {
    ExpressionTree left = Product();
    while (reader_.Peek().Is("+") || reader_.Peek().Is("-")) {
      std::string word = reader_.Take().word;
      left = Binary(std::move(word), std::move(left), Product());
    }
    return left;
  }

  static bool IsPlainNumber(const Expression& tree) {
    return tree.kind == ExpressionKind::kNumber && !tree.unit;
  }

  ExpressionTree Product() {
    std::vector<ExpressionTree> factors = Factors();
    bool number_before = factors.size() == 1 && IsPlainNumber(*factors.back());
    ExpressionTree left = Multiplied(std::move(factors), nullptr);
    while (true) {
      const Token& sign = reader_.Peek();
      if (sign.Is("*") || sign.Is("·") || sign.Is("×")) {
        std::string word = reader_.Take().word;
        std::vector<ExpressionTree> right = Factors();
        number_before = right.size() == 1 && IsPlainNumber(*right.back());
        left = Binary(std::move(word), std::move(left), Multiplied(std::move(right), nullptr));
      } else if (sign.Is("/")) {
        reader_.Take();
        std::vector<ExpressionTree> right = Factors();
        const bool fraction = number_before && IsPlainNumber(*right.front());
        if (right.size() > 1 && !fraction) FailAmbiguous(*left, right);
        number_before = right.size() == 1 && IsPlainNumber(*right.back());
        ExpressionTree divisor = std::move(right.front());
        right.erase(right.begin());
        left = Multiplied(std::move(right), Binary("/", std::move(left), std::move(divisor)));
      } else if (sign.Is("**")) {
        reader_.problems().Fail(sign.span, "'**' has no meaning in a law", "write ^ for a power");
      } else {
        if (sign.Is("%")) {
          reader_.problems().Fail(sign.span, "'%' has no meaning here",
                                  "the remainder of a divided by b is a - b floor(a/b)");
        }
        return left;
      }
    }
  }

  std::string Source(Span span) const {
    return std::string(reader_.text().substr(span.begin, span.end - span.begin));
  }

  [[noreturn]] void FailAmbiguous(const Expression& left,
                                  const std::vector<ExpressionTree>& right) {
    const std::string over = Source(left.span), under = Source(right.front()->span);
    const std::string rest = Source(Join(right[1]->span, right.back()->span));
    const Expression& divisor = *right.front();
    const Expression& symbol =
        divisor.kind == ExpressionKind::kBinary ? *divisor.parts[0] : divisor;
    if (symbol.kind == ExpressionKind::kName && IsUnit(symbol.word)) {
      reader_.problems().Fail(Join(left.span, right.back()->span),
                              "a division before a product without a sign can be read in two ways",
                              "if this is a unit, write it without spaces, such as 3 kg*m/s^2");
    }
    reader_.problems().Fail(
        Join(left.span, right.back()->span),
        "a division before a product without a sign can be read in two ways",
        "write " + over + "/(" + under + " " + rest + ") or " + over + "/" + under + " * " + rest);
  }

  ExpressionTree Multiplied(std::vector<ExpressionTree> factors, ExpressionTree left) {
    for (ExpressionTree& factor : factors) {
      left = left == nullptr ? std::move(factor) : Binary("*", std::move(left), std::move(factor));
    }
    return left;
  }

  bool StartsFactor() const {
    const Token& next = reader_.Peek();
    if (next.kind == TokenKind::kName) return !IsReserved(next.word);
    return next.Is("(") || next.Is("√") || (next.Is("|") && !in_length_);
  }

  /// Parses adjacent factors, which are multiplied, such as 4 epsilon (a - b).
  std::vector<ExpressionTree> Factors() {
    std::vector<ExpressionTree> factors;
    factors.push_back(Signed());
    while (StartsFactor()) factors.push_back(Power());
    if (reader_.Peek().kind == TokenKind::kNumber) {
      reader_.problems().Fail(reader_.Peek().span,
                              "a number behind a value: a sign is missing between them",
                              "write " + Source(factors.back()->span) + " * " +
                                  reader_.Peek().word + ", or the number first");
    }
    return factors;
  }

  ExpressionTree Signed() {
    const Depth depth(*this);
    const Token& sign = reader_.Peek();
    if (sign.Is("+")) {
      reader_.Take();
      return Signed();
    }
    if (!sign.Is("-")) return Power();
    const Span begin = reader_.Take().span;
    ExpressionTree inner = Signed();
    ExpressionTree tree = Make(ExpressionKind::kNegative, Join(begin, inner->span));
    tree->parts.push_back(std::move(inner));
    return tree;
  }

  ExpressionTree Power() {
    ExpressionTree base = Postfix();
    if (!reader_.Peek().Is("^")) return base;
    reader_.Take();
    const Depth depth(*this);
    ExpressionTree exponent;
    if (reader_.Peek().Is("-") || reader_.Peek().Is("+")) {
      const bool negative = reader_.Peek().Is("-");
      const Span begin = reader_.Take().span;
      exponent = Postfix();
      if (negative) {
        ExpressionTree tree = Make(ExpressionKind::kNegative, Join(begin, exponent->span));
        tree->parts.push_back(std::move(exponent));
        exponent = std::move(tree);
      }
    } else {
      exponent = Postfix(false);
    }
    if (reader_.Peek().Is("^")) {
      reader_.problems().Fail(reader_.Peek().span, "a power of a power needs brackets",
                              "write (a^b)^c or a^(b^c)");
    }
    return Binary("^", std::move(base), std::move(exponent));
  }

  ExpressionTree Postfix(bool with_unit = true) {
    ExpressionTree tree = Primary(with_unit);
    while (reader_.Peek().Is(".")) {
      reader_.Take();
      const Name member = reader_.ExpectName("a property or a component behind the dot");
      ExpressionTree outer = Make(ExpressionKind::kMember, Join(tree->span, member.span));
      outer->word = member.word;
      outer->parts.push_back(std::move(tree));
      tree = std::move(outer);
    }
    return tree;
  }

  ExpressionTree Primary(bool with_unit) {
    const Token token = reader_.Peek();
    if (token.kind == TokenKind::kNumber) {
      reader_.Take();
      ExpressionTree tree = Make(ExpressionKind::kNumber, token.span);
      tree->number = token.number;
      if (with_unit) TakeUnit(*tree);
      return tree;
    }
    if (token.kind == TokenKind::kName && !IsReserved(token.word)) return NameOrCall();
    if (token.Is("(")) return Bracket();
    if (token.Is("|")) return Length();
    if (token.Is("√")) return Root();
    reader_.FailHere("a value: a number, a name or '('");
  }

  /// Reads the unit behind a number or a tuple, if there is one.
  void TakeUnit(Expression& tree) {
    const std::string_view text = reader_.text();
    size_t begin = tree.span.end;
    while (begin < text.size() && text[begin] == ' ') ++begin;
    const Token& next = reader_.Peek();
    if (next.span.begin != begin || next.kind == TokenKind::kEnd) return;
    // Skips the "1/" of units such as 1/s, as in 3 1/s.
    const size_t inverse = text.substr(begin).starts_with("1/") ? begin + 2 : begin;
    UnitScanner scanner(text, inverse);
    const size_t end = scanner.Run();
    if (end == inverse) return;
    try {
      tree.unit = ParseUnitOrThrowWhere(text.substr(begin, end - begin));
    } catch (const UnitError& error) {
      reader_.problems().Fail({static_cast<uint32_t>(begin), static_cast<uint32_t>(end)},
                              error.message);
    }
    tree.unit_symbols = scanner.symbols();
    tree.span.end = static_cast<uint32_t>(end);
    reader_.SkipTo(static_cast<uint32_t>(end));
  }

  ExpressionTree NameOrCall() {
    const Token name = reader_.Take();
    if (!IsFunction(name.word) || !reader_.Peek().Is("(")) {
      ExpressionTree tree = Make(ExpressionKind::kName, name.span);
      tree->word = name.word;
      return tree;
    }
    reader_.Take();
    ExpressionTree call = Make(ExpressionKind::kCall, name.span);
    call->word = name.word;
    const bool in_length = std::exchange(in_length_, false);
    call->parts.push_back(Conditional());
    while (reader_.Takes(",")) call->parts.push_back(Conditional());
    in_length_ = in_length;
    call->span = Join(name.span, reader_.Expect(")", "at the end of " + name.word + "(…").span);
    return call;
  }

  ExpressionTree Bracket() {
    const Span begin = reader_.Take().span;
    const bool in_length = std::exchange(in_length_, false);
    ExpressionTree first = Conditional();
    if (!reader_.Peek().Is(",")) {
      in_length_ = in_length;
      const Span end = reader_.Expect(")", "to close the bracket").span;
      first->span = Join(begin, end);
      return first;
    }
    ExpressionTree tuple = Make(ExpressionKind::kTuple, begin);
    tuple->parts.push_back(std::move(first));
    while (reader_.Takes(",")) tuple->parts.push_back(Conditional());
    in_length_ = in_length;
    tuple->span = Join(begin, reader_.Expect(")", "to close the vector").span);
    TakeUnit(*tuple);
    return tuple;
  }

  ExpressionTree Length() {
    const Depth depth(*this);
    const Span begin = reader_.Take().span;
    const bool in_length = std::exchange(in_length_, true);
    ExpressionTree inner = Sum();
    in_length_ = in_length;
    if (!reader_.Peek().Is("|")) reader_.FailHere("'|' to close the length that begins with '|'");
    ExpressionTree tree = Make(ExpressionKind::kLength, Join(begin, reader_.Take().span));
    tree->parts.push_back(std::move(inner));
    return tree;
  }

  ExpressionTree Root() {
    const Depth depth(*this);
    const Span begin = reader_.Take().span;
    ExpressionTree inner = Postfix();
    ExpressionTree tree = Make(ExpressionKind::kCall, Join(begin, inner->span));
    tree->word = "sqrt";
    tree->parts.push_back(std::move(inner));
    return tree;
  }

  TokenReader& reader_;
  int depth_ = 0;
  int parts_ = 0;
  bool in_length_ = false;  // true if a '|' would close a length
};

}  // namespace

TokenReader::TokenReader(std::string_view text, Problems& problems)
    : text_(text), problems_(problems), tokens_(Tokens(text, problems)) {}

const Token& TokenReader::Peek(size_t ahead) const {
  return tokens_[std::min(at_ + ahead, tokens_.size() - 1)];
}

Token TokenReader::Take() {
  Token token = Peek();
  if (at_ + 1 < tokens_.size()) ++at_;
  return token;
}

bool TokenReader::Takes(std::string_view word) {
  if (!Peek().Is(word)) return false;
  Take();
  return true;
}

Token TokenReader::Expect(std::string_view word, std::string_view where) {
  if (Peek().Is(word)) return Take();
  FailHere("'" + std::string(word) + "' " + std::string(where));
}

Name TokenReader::ExpectName(std::string_view what) {
  const Token& token = Peek();
  if (token.kind != TokenKind::kName) FailHere(std::string(what));
  if (IsReserved(token.word)) {
    FailHere(std::string(what), "'" + token.word + "' is a word of the language");
  }
  const Token name = Take();
  return {name.word, name.span};
}

void TokenReader::FailHere(const std::string& expected, std::string hint) {
  const Token& token = Peek();
  Span span = token.span;
  if (span.end == span.begin) span.end = span.begin + 1;  // marks the end of the line
  problems_.Fail(span, "found " + Found(token) + ", expected " + expected, std::move(hint));
}

bool TokenReader::AtLineEnd() const {
  return Peek().kind == TokenKind::kLineEnd || Peek().kind == TokenKind::kEnd ||
         Peek().kind == TokenKind::kDedent;
}

void TokenReader::SkipTo(uint32_t offset) {
  while (Peek().kind != TokenKind::kEnd && Peek().kind != TokenKind::kLineEnd &&
         Peek().span.begin < offset) {
    Take();
  }
}

ExpressionTree ParseExpression(TokenReader& reader) {
  return ExpressionParser(reader).Conditional();
}

vesper_unit ParseUnitHere(TokenReader& reader, Span& span) {
  const size_t begin = reader.Peek().span.begin;
  if (reader.Peek().kind == TokenKind::kNumber && reader.Peek().number == 1) {
    // The unit is "1", or begins with "1/", such as "1/s".
    const std::string_view text = reader.text();
    size_t end = reader.Peek().span.end;
    if (end < text.size() && text[end] == '/') {
      const size_t behind = UnitScanner(text, end + 1).Run();
      if (behind > end + 1) end = behind;
    }
    span = {static_cast<uint32_t>(begin), static_cast<uint32_t>(end)};
    reader.SkipTo(span.end);
    try {
      return ParseUnitOrThrowWhere(text.substr(begin, end - begin));
    } catch (const UnitError& error) {
      reader.problems().Fail(span, error.message);
    }
  }
  const size_t end = UnitScanner(reader.text(), begin).Run();
  if (end == begin) {
    std::string hint;
    if (reader.Peek().kind == TokenKind::kName) {
      try {
        ParseUnitOrThrowWhere(reader.Peek().word);
      } catch (const UnitError& error) {
        hint = error.message;
      }
    }
    reader.FailHere("a unit such as m/s, kg or 1", hint);
  }
  span = {static_cast<uint32_t>(begin), static_cast<uint32_t>(end)};
  reader.SkipTo(span.end);
  try {
    return ParseUnitOrThrowWhere(reader.text().substr(begin, end - begin));
  } catch (const UnitError& error) {
    reader.problems().Fail(span, error.message);
  }
}

}  // namespace vesper::text
