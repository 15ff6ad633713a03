// SPDX-License-Identifier: Apache-2.0
#include "token.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace vesper::text {
namespace {

constexpr size_t kMaxNesting = 32;

struct Spelling {
  std::string_view printed;
  std::string_view ascii;
};

constexpr Spelling kGreek[] = {
    {"α", "alpha"},  {"β", "beta"},  {"γ", "gamma"}, {"δ", "delta"}, {"ε", "epsilon"},
    {"ζ", "zeta"},   {"η", "eta"},   {"θ", "theta"}, {"κ", "kappa"}, {"λ", "lambda"},
    {"μ", "mu"},     {"µ", "mu"},    {"ν", "nu"},    {"ξ", "xi"},    {"π", "pi"},
    {"ρ", "rho"},    {"σ", "sigma"}, {"τ", "tau"},   {"φ", "phi"},   {"χ", "chi"},
    {"ψ", "psi"},    {"ω", "omega"}, {"Γ", "Gamma"}, {"Δ", "Delta"}, {"Θ", "Theta"},
    {"Λ", "Lambda"}, {"Φ", "Phi"},   {"Ψ", "Psi"},   {"Ω", "Omega"}};

constexpr Spelling kSigns[] = {{"−", "-"},   {"×", "×"},   {"·", "·"},   {"⋅", "·"},   {"≤", "<="},
                               {"≥", ">="},  {"≠", "!="},  {"√", "√"},   {"+=", "+="}, {"-=", "-="},
                               {"*=", "*="}, {"/=", "/="}, {"<=", "<="}, {">=", ">="}, {"!=", "!="},
                               {"==", "=="}, {"**", "**"}, {"&&", "&&"}, {"||", "||"}, {"%", "%"},
                               {"°", "°"}};
constexpr std::string_view kSingles = "+-*/^()|,:;.=<>!%[]{}&?@~$'`\\";

constexpr std::string_view kRaised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
constexpr std::string_view kRaisedMinus = "⁻";

bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool IsDigit(char c) { return c >= '0' && c <= '9'; }

class Lexer {
 public:
  Lexer(std::string_view text, Problems& problems) : text_(text), problems_(problems) {}

  std::vector<Token> Run() {
    if (IsNext("\xef\xbb\xbf")) at_ += 3;
    while (at_ < text_.size() && !problems_.full()) Line();
    EndLine();
    while (indents_.size() > 1) {
      indents_.pop_back();
      Push(TokenKind::kDedent, at_, at_);
    }
    Push(TokenKind::kEnd, at_, at_);
    return std::move(tokens_);
  }

 private:
  bool IsNext(std::string_view word) const { return text_.substr(at_).starts_with(word); }
  char Here() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void Push(TokenKind kind, size_t begin, size_t end, std::string word = {}, double number = 0) {
    tokens_.push_back({kind,
                       {static_cast<uint32_t>(begin), static_cast<uint32_t>(end)},
                       std::move(word),
                       number});
  }
  bool OpensLine() const {
    return tokens_.empty() || tokens_.back().kind == TokenKind::kLineEnd ||
           tokens_.back().kind == TokenKind::kIndent || tokens_.back().kind == TokenKind::kDedent;
  }
  void EndLine() {
    if (OpensLine()) return;
    const size_t end = tokens_.back().span.end;
    Push(TokenKind::kLineEnd, end, end);
  }

  void Line() {
    const size_t begin = at_;
    while (Here() == ' ' || Here() == '\t') ++at_;
    if (Here() == '\r' || Here() == '\n' || Here() == '#' || at_ == text_.size()) {
      SkipLine();
      return;
    }
    if (!Continues()) {
      EndLine();
      Indentation(begin);
    }
    while (at_ < text_.size() && Here() != '\n') Next();
    if (at_ < text_.size()) ++at_;
  }

  void SkipLine() {
    while (at_ < text_.size() && Here() != '\n') ++at_;
    if (at_ < text_.size()) ++at_;
  }

  /// Returns true if the line continues the previous one.
  bool Continues() {
    if (OpensLine()) return false;
    if (brackets_ > 0) return true;
    const Token& last = tokens_.back();
    if (last.kind == TokenKind::kSign && last.word != ")" && last.word != "|" && last.word != ":" &&
        last.word != ";" && last.word != "%") {
      return true;
    }
    for (const std::string_view sign : {"+", "*", "/", "·", "×", "^", "<", ">", "≤", "≥"}) {
      if (IsNext(sign)) return true;
    }
    return IsNext("- ") || IsNext("−");
  }

  void Indentation(size_t begin) {
    size_t width = 0;
    for (size_t i = begin; i < at_; ++i) width += text_[i] == '\t' ? 8 - width % 8 : 1;
    if (width > indents_.back()) {
      if (indents_.size() > kMaxNesting) {
        problems_.Add({static_cast<uint32_t>(at_), static_cast<uint32_t>(at_ + 1)},
                      "blocks are nested more than 32 deep");
        return;
      }
      indents_.push_back(width);
      Push(TokenKind::kIndent, at_, at_);
      return;
    }
    while (width < indents_.back()) {
      indents_.pop_back();
      Push(TokenKind::kDedent, at_, at_);
      if (width > indents_.back()) {
        problems_.Add({static_cast<uint32_t>(at_), static_cast<uint32_t>(at_ + 1)},
                      "this line begins between two blocks: " + std::to_string(width) +
                          " spaces, expected " + std::to_string(indents_.back()) +
                          " or more than "
                          "the line above",
                      "align it with the lines of the block that it belongs to");
        indents_.push_back(width);
        Push(TokenKind::kIndent, at_, at_);
        return;
      }
    }
  }

  void Next() {
    const char c = Here();
    if (c == ' ' || c == '\t' || c == '\r') {
      ++at_;
    } else if (c == '#') {
      while (at_ < text_.size() && Here() != '\n') ++at_;
    } else if (c == '"') {
      Text();
    } else if (IsDigit(c) || (c == '.' && at_ + 1 < text_.size() && IsDigit(text_[at_ + 1]))) {
      Number();
    } else if (!Raised() && !Half() && !Name()) {
      Sign();
    }
  }

  void Text() {
    const size_t begin = at_++;
    while (at_ < text_.size() && Here() != '"' && Here() != '\n') ++at_;
    std::string word(text_.substr(begin + 1, at_ - begin - 1));
    if (Here() != '"') {
      problems_.Add({static_cast<uint32_t>(begin), static_cast<uint32_t>(at_)},
                    "the text in quotation marks does not end in this line",
                    "write a \" behind its last word");
    } else {
      ++at_;
    }
    while (!word.empty() && word.back() == '\r') word.pop_back();
    Push(TokenKind::kText, begin, at_, std::move(word));
  }

  void Number() {
    const size_t begin = at_;
    double value = 0;
    const char* end_of_text = text_.data() + text_.size();
    const auto [end, error] = std::from_chars(text_.data() + at_, end_of_text, value);
    at_ = static_cast<size_t>(end - text_.data());
    if (error == std::errc::result_out_of_range || !std::isfinite(value)) {
      problems_.Add({static_cast<uint32_t>(begin), static_cast<uint32_t>(at_)},
                    "the number is outside 1e-308 to 1e308");
    }
    Push(TokenKind::kNumber, begin, at_, std::string(text_.substr(begin, at_ - begin)), value);
  }

  bool Half() {
    for (const auto& [sign, value] :
         {std::pair<std::string_view, double>{"½", 0.5}, {"¼", 0.25}, {"¾", 0.75}}) {
      if (!IsNext(sign)) continue;
      Push(TokenKind::kNumber, at_, at_ + sign.size(), std::string(sign), value);
      at_ += sign.size();
      return true;
    }
    return false;
  }

  bool Raised() {
    const size_t begin = at_;
    const bool minus = IsNext(kRaisedMinus);
    if (minus) at_ += kRaisedMinus.size();
    double value = 0;
    size_t digits = 0;
    for (bool found = true; found && digits < 9;) {
      found = false;
      for (size_t digit = 0; digit < 10; ++digit) {
        if (!IsNext(kRaised[digit])) continue;
        value = 10 * value + static_cast<double>(digit);
        at_ += kRaised[digit].size();
        ++digits;
        found = true;
        break;
      }
    }
    if (digits == 0) {
      at_ = begin;
      return false;
    }
    Push(TokenKind::kSign, begin, at_, "^");
    if (minus) Push(TokenKind::kSign, begin, at_, "-");
    Push(TokenKind::kNumber, begin, at_, std::string(text_.substr(begin, at_ - begin)), value);
    return true;
  }

  bool Greek(std::string& name) {
    for (const auto& [letter, ascii] : kGreek) {
      if (!IsNext(letter)) continue;
      name += ascii;
      at_ += letter.size();
      return true;
    }
    return false;
  }

  bool Name() {
    const size_t begin = at_;
    std::string name;
    while (true) {
      if (IsLetter(Here()) || (!name.empty() && IsDigit(Here()))) {
        name += text_[at_++];
      } else if (!Greek(name)) {
        break;
      }
    }
    if (name.empty()) return false;
    Push(TokenKind::kName, begin, at_, std::move(name));
    return true;
  }

  void Sign() {
    for (const auto& [printed, ascii] : kSigns) {
      if (!IsNext(printed)) continue;
      Push(TokenKind::kSign, at_, at_ + printed.size(), std::string(ascii));
      at_ += printed.size();
      return;
    }
    const size_t begin = at_++;
    if (kSingles.find(text_[begin]) != std::string_view::npos) {
      if (text_[begin] == '(') ++brackets_;
      if (text_[begin] == ')' && brackets_ > 0) --brackets_;
      Push(TokenKind::kSign, begin, at_, std::string(1, text_[begin]));
      return;
    }
    while (at_ < text_.size() && (static_cast<unsigned char>(text_[at_]) & 0xc0) == 0x80) ++at_;
    const bool printable = static_cast<unsigned char>(text_[begin]) >= ' ' && text_[begin] != 0x7f;
    problems_.Add({static_cast<uint32_t>(begin), static_cast<uint32_t>(at_)},
                  printable ? "'" + std::string(text_.substr(begin, at_ - begin)) +
                                  "' has no meaning in a law"
                            : "the text contains a control character");
  }

  std::string_view text_;
  Problems& problems_;
  std::vector<Token> tokens_;
  std::vector<size_t> indents_{0};
  size_t at_ = 0;
  size_t brackets_ = 0;
};

}  // namespace

std::vector<Token> Tokens(std::string_view text, Problems& problems) {
  return Lexer(text, problems).Run();
}

std::string Found(const Token& token) {
  switch (token.kind) {
    case TokenKind::kLineEnd:
      return "the end of the line";
    case TokenKind::kEnd:
    case TokenKind::kDedent:
      return "the end of the block";
    case TokenKind::kIndent:
      return "an indented line";
    case TokenKind::kText:
      return "a text in quotation marks";
    default:
      return "'" + token.word + "'";
  }
}

}  // namespace vesper::text
