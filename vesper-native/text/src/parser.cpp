// SPDX-License-Identifier: Apache-2.0
// Parser of the laws, declarations, blocks and statements of a law text.
#include <algorithm>
#include <cstdio>
#include <iterator>

#include "expression_parser.hpp"
#include "nearest_name.hpp"
#include "syntax.hpp"

namespace vesper::text {
namespace {

constexpr int kMaxBlockDepth = 16;
constexpr size_t kMaxStatements = 1000;

constexpr std::string_view kFunctions[] = {
    "sqrt", "abs",  "sign", "floor", "min",       "max",    "clamp",    "sin",       "cos",
    "tan",  "asin", "acos", "atan",  "atan2",     "exp",    "ln",       "log10",     "tanh",
    "sinh", "cosh", "dot",  "cross", "direction", "rotate", "unrotate", "quaternion"};

constexpr std::string_view kReserved[] = {"law",  "parameter", "each",  "pair",    "of",  "from",
                                          "to",   "within",    "apart", "along",   "let", "if",
                                          "else", "and",       "or",    "not",     "has", "may",
                                          "have", "in",        "phase", "version", "at"};

constexpr std::string_view kPhases[] = {"force", "integrate", "constrain", "observe"};

class Parser {
 public:
  Parser(std::string_view text, Problems& problems) : reader_(text, problems) {}

  std::vector<LawTree> Run() {
    std::vector<LawTree> laws;
    if (!reader_.problems().empty()) return laws;  // further problems would be consequences
    while (reader_.Peek().kind != TokenKind::kEnd && !reader_.problems().full()) {
      Guarded([&] {
        if (!reader_.Peek().Is("law")) {
          reader_.FailHere("'law' and a name at the beginning of the text",
                           "begin with a line such as: law wind \"Drag towards a wind.\"");
        }
        laws.push_back(Law());
      });
    }
    if (laws.empty() && reader_.problems().empty()) {
      reader_.problems().Add({0, 1}, "the text is empty, expected a law",
                             "begin with a line such as: law wind \"Drag towards a wind.\"");
    }
    return laws;
  }

 private:
  /// Runs `body`. Continues after a problem with the text after the line and its indented block.
  template <class Body>
  void Guarded(Body&& body) {
    const uint32_t begin = reader_.Peek().span.begin;
    try {
      body();
    } catch (const Abandon&) {
      SkipStatement();
      if (reader_.Peek().span.begin == begin && reader_.Peek().kind != TokenKind::kEnd) {
        reader_.Take();
      }
    }
  }

  void SkipStatement() {
    while (!reader_.AtLineEnd() && reader_.Peek().kind != TokenKind::kIndent) reader_.Take();
    if (reader_.Peek().kind == TokenKind::kLineEnd) reader_.Take();
    if (reader_.Peek().kind != TokenKind::kIndent) return;
    size_t depth = 0;
    do {
      const TokenKind kind = reader_.Take().kind;
      if (kind == TokenKind::kIndent) ++depth;
      if (kind == TokenKind::kDedent) --depth;
      if (kind == TokenKind::kEnd) return;
    } while (depth > 0);
  }

  void EndLine() {
    if (reader_.Peek().kind == TokenKind::kDedent || reader_.Peek().kind == TokenKind::kEnd) return;
    if (reader_.Peek().kind != TokenKind::kLineEnd) reader_.FailHere("the end of the line");
    reader_.Take();
  }

  LawTree Law() {
    reader_.Take();
    LawTree law;
    law.name = reader_.ExpectName("the name of the law");
    if (law.name.word.size() > 40) {
      reader_.problems().Fail(law.name.span, "the name has more than 40 letters");
    }
    if (reader_.Peek().kind == TokenKind::kText) law.doc = reader_.Take().word;
    reader_.Takes(":");
    EndLine();
    if (reader_.Peek().kind != TokenKind::kIndent) {
      reader_.FailHere("the indented lines of law " + law.name.word,
                       "begin each line of the law with two spaces");
    }
    reader_.Take();
    while (reader_.Peek().kind != TokenKind::kDedent && reader_.Peek().kind != TokenKind::kEnd &&
           !reader_.problems().full()) {
      Guarded([&] { Member(law); });
    }
    if (reader_.Peek().kind == TokenKind::kDedent) reader_.Take();
    return law;
  }

  void Member(LawTree& law) {
    if (reader_.Takes("parameter")) {
      Parameters(law);
    } else if (reader_.Peek().Is("field") && reader_.Peek(1).kind == TokenKind::kName) {
      reader_.Take();
      Field(law);
    } else if (reader_.Takes("version")) {
      Version(law);
    } else if (reader_.Takes("phase")) {
      Phase(law);
    } else if (reader_.Peek().Is("let")) {
      law.lets.push_back(Let());
      if (law.lets.size() > kMaxStatements) {
        reader_.problems().Fail(law.lets.back().span, "the law has more than 1000 lets");
      }
      EndLine();
    } else if (reader_.Peek().Is("each")) {
      Each(law, std::nullopt);
    } else if (reader_.Takes("at")) {
      Stage(law);
    } else {
      const Token& next = reader_.Peek();
      const bool statement =
          next.kind == TokenKind::kName && (reader_.Peek(1).Is("+=") || reader_.Peek(1).Is("-=") ||
                                            reader_.Peek(1).Is("=") || reader_.Peek(1).Is("."));
      if (statement || next.Is("if")) {
        reader_.FailHere("a block that says which rows this is for",
                         "write it, indented, below a line such as: each body:");
      }
      static const std::vector<std::string> kMembers{"parameter", "let",   "each",
                                                     "phase",     "field", "version"};
      const std::string* nearest = NearestName(next.word, kMembers);
      reader_.FailHere("'parameter', 'let', 'each', 'phase', 'field' or 'version'",
                       nearest == nullptr ? "" : "did you mean '" + *nearest + "'?");
    }
  }

  /// Gives a plain number the unit of the number behind `to`, as in `from 1 to 5 kg`.
  static void ShareUnit(Expression& minimum, const Expression& maximum) {
    const auto literal = [](auto& tree) {
      return tree.kind == ExpressionKind::kNegative ? tree.parts[0].get() : &tree;
    };
    Expression* low = literal(minimum);
    const Expression* high = literal(maximum);
    if (low->kind == ExpressionKind::kNumber && high->kind == ExpressionKind::kNumber &&
        !low->unit) {
      low->unit = high->unit;
    }
  }

  void Parameters(LawTree& law) {
    do {
      ParameterTree parameter;
      parameter.name = reader_.ExpectName("the name of a parameter");
      reader_.Expect("=", "and a value behind the parameter " + parameter.name.word);
      parameter.value = ParseExpression(reader_);
      while (reader_.Peek().Is(",") && reader_.Peek(1).Is("from")) {
        reader_.Take();
        reader_.Take();
        parameter.minimum = ParseExpression(reader_);
        reader_.Expect("to", "and the greatest value");
        parameter.maximum = ParseExpression(reader_);
        ShareUnit(*parameter.minimum, *parameter.maximum);
      }
      if (reader_.Peek().kind == TokenKind::kText) parameter.doc = reader_.Take().word;
      law.parameters.push_back(std::move(parameter));
    } while (reader_.Takes(","));
    EndLine();
  }

  void Field(LawTree& law) {
    FieldTree field;
    field.name = reader_.ExpectName("the name of a field");
    reader_.Expect("at", "and a name for the place, such as: field wind at place = …");
    field.place = reader_.ExpectName("a name for the place");
    reader_.Expect("=", "and the value of the field " + field.name.word);
    field.value = ParseExpression(reader_);
    if (reader_.Peek().kind == TokenKind::kText) field.doc = reader_.Take().word;
    law.fields.push_back(std::move(field));
    EndLine();
  }

  void Version(LawTree& law) {
    const uint32_t begin = reader_.Peek().span.begin;
    uint32_t end = begin;
    while (!reader_.AtLineEnd()) end = reader_.Take().span.end;
    law.version = std::string(reader_.text().substr(begin, end - begin));
    const bool digits = std::all_of(law.version.begin(), law.version.end(),
                                    [](char c) { return c == '.' || (c >= '0' && c <= '9'); });
    unsigned major, minor, patch;
    int length = 0;
    if (!digits || law.version.size() > 24 ||
        std::sscanf(law.version.c_str(), "%u.%u.%u%n", &major, &minor, &patch, &length) != 3 ||
        law.version[static_cast<size_t>(length)] != '\0') {
      reader_.problems().Fail({begin, end}, "the version is not of the form 1.2.3");
    }
    EndLine();
  }

  void Phase(LawTree& law) {
    const Token token = reader_.Take();
    if (std::find(std::begin(kPhases), std::end(kPhases), token.word) == std::end(kPhases)) {
      reader_.problems().Fail(token.span, "found " + Found(token) +
                                              ", expected force, integrate, constrain or observe");
    }
    law.phase = Name{token.word, token.span};
    while (reader_.Takes(",")) {
      const Token number = reader_.Peek();
      if (number.Is("weights")) {
        reader_.Take();
        law.weights.push_back(ParseExpression(reader_));
        while (reader_.Takes(",")) law.weights.push_back(ParseExpression(reader_));
        break;
      }
      if (number.kind != TokenKind::kNumber || number.number < 1 || number.number > 16 ||
          number.number != static_cast<int>(number.number)) {
        reader_.FailHere("the number of stages, 1 to 16, such as: phase integrate, 4 stages");
      }
      reader_.Take();
      law.stages = static_cast<uint32_t>(number.number);
      if (!reader_.Takes("stage")) reader_.Expect("stages", "behind their number");
    }
    EndLine();
  }

  void Stage(LawTree& law) {
    reader_.Expect("stage", "behind 'at'");
    const Token number = reader_.Peek();
    if (number.kind != TokenKind::kNumber || number.number < 0 || number.number > 16 ||
        number.number != static_cast<int>(number.number)) {
      reader_.FailHere("the number of a stage, 0 to 16");
    }
    reader_.Take();
    reader_.Expect(":", "behind the number of the stage");
    EndLine();
    if (reader_.Peek().kind != TokenKind::kIndent) {
      reader_.FailHere("the indented blocks of the stage");
    }
    reader_.Take();
    while (reader_.Peek().kind != TokenKind::kDedent && reader_.Peek().kind != TokenKind::kEnd) {
      Guarded([&] {
        if (!reader_.Peek().Is("each")) reader_.FailHere("'each'");
        Each(law, static_cast<uint32_t>(number.number));
      });
      if (reader_.problems().full()) return;
    }
    if (reader_.Peek().kind == TokenKind::kDedent) reader_.Take();
  }

  void Each(LawTree& law, std::optional<uint32_t> stage) {
    const Span begin = reader_.Take().span;
    depth_ = 0;
    if (reader_.Takes("pair")) {
      Block block = PairHeading(begin);
      block.stage = stage;
      FinishBlock(law, std::move(block));
      return;
    }
    const Name rows = reader_.ExpectName("a kind of rows, such as body or spring, or 'pair'");
    if (reader_.Takes("has")) {
      Owned(law, rows, false);
      return;
    }
    if (reader_.Takes("may")) {
      reader_.Expect("have", "behind 'may'");
      Owned(law, rows, true);
      return;
    }
    Block block{.kind = BlockKind::kRows, .span = Join(begin, rows.span), .rows = rows};
    block.stage = stage;
    if (reader_.Takes("from")) {
      block.kind = BlockKind::kJoined;
      block.participants.push_back(reader_.ExpectName("a name for the first end"));
      reader_.Expect("to", "and a name for the second end");
      block.participants.push_back(reader_.ExpectName("a name for the second end"));
      while (reader_.Takes(",")) PairClause(block);
    } else if (reader_.Takes("of")) {
      block.kind = BlockKind::kJoined;
      do {
        block.participants.push_back(reader_.ExpectName("a name for a row that it refers to"));
      } while (reader_.Takes(","));
    }
    FinishBlock(law, std::move(block));
  }

  void Owned(LawTree& law, const Name& rows, bool optional) {
    do {
      Ownership owned;
      owned.rows = rows;
      owned.optional = optional;
      if (reader_.Peek().Is("a") && reader_.Peek(1).kind == TokenKind::kName &&
          !IsReserved(reader_.Peek(1).word)) {
        reader_.Take();
      }
      if (reader_.Peek().Is("vector") && reader_.Peek(1).kind == TokenKind::kName &&
          !IsReserved(reader_.Peek(1).word)) {
        reader_.Take();
        owned.components = 3;
      }
      owned.name = reader_.ExpectName("the name of a property");
      if (owned.name.word.size() > 47) {
        reader_.problems().Fail(owned.name.span, "the name has more than 47 letters");
      }
      if (reader_.Takes("in")) owned.unit = ParseUnitHere(reader_, owned.unit_span);
      if (reader_.Peek().Is(",") && reader_.Peek(1).Is("from")) {
        reader_.Take();
        owned.limits_span = reader_.Take().span;
        owned.minimum = ParseExpression(reader_);
        Span last = owned.minimum->span;
        if (reader_.Takes("to")) {
          owned.maximum = ParseExpression(reader_);
          ShareUnit(*owned.minimum, *owned.maximum);
          last = owned.maximum->span;
        }
        owned.limits_span = Join(owned.limits_span, last);
      }
      law.owned.push_back(std::move(owned));
    } while (reader_.Takes(","));
    EndLine();
  }

  Block PairHeading(Span begin) {
    Block block{.kind = BlockKind::kPairs, .span = begin, .rows = {}};
    if (!reader_.Peek().Is("of")) {
      block.participants.push_back(reader_.ExpectName("'of' and a kind, or names for the two"));
      if (!reader_.Takes(",")) reader_.Expect("and", "and a name for the second of the pair");
      block.participants.push_back(reader_.ExpectName("a name for the second of the pair"));
    }
    reader_.Expect("of", "and a kind, such as: each pair of bodies");
    block.rows = reader_.ExpectName("a kind of rows, such as bodies");
    block.span = Join(begin, block.rows.span);
    if (reader_.Takes("within")) block.within = ParseExpression(reader_);
    while (reader_.Takes(",")) PairClause(block);
    return block;
  }

  void PairClause(Block& block) {
    if (reader_.Peek().Is("energy")) {
      const Span begin = reader_.Take().span;
      const Token word = reader_.Take();
      block.edge = word.Is("cut")       ? Edge::kCut
                   : word.Is("shifted") ? Edge::kShifted
                   : word.Is("smooth")  ? Edge::kSmooth
                                        : Edge::kUnsaid;
      block.edge_span = Join(begin, word.span);
      if (block.edge == Edge::kUnsaid) {
        reader_.problems().Fail(word.span,
                                "found " + Found(word) + ", expected cut, shifted or smooth");
      }
      return;
    }
    block.distance = reader_.ExpectName("a name for the distance, such as: r apart");
    reader_.Expect("apart", "behind the name of the distance");
    if (reader_.Takes("along")) block.direction = reader_.ExpectName("a name for the direction");
  }

  void FinishBlock(LawTree& law, Block block) {
    if (!reader_.Peek().Is(":")) {
      std::string hint;
      if (block.kind == BlockKind::kPairs && !block.distance) {
        hint = "a name for the distance comes behind a comma, such as: within 2 m, r apart:";
      }
      reader_.FailHere("':' at the end of the heading", hint);
    }
    block.span = Join(block.span, reader_.Take().span);
    block.statements = Body();
    law.blocks.push_back(std::move(block));
  }

  /// Parses statements behind a colon, in the same line or indented below it.
  std::vector<Statement> Body() {
    std::vector<Statement> statements;
    if (reader_.Peek().kind != TokenKind::kLineEnd) {
      Line(statements);
      return statements;
    }
    reader_.Take();
    if (reader_.Peek().kind != TokenKind::kIndent) {
      reader_.FailHere("an indented line below the ':'",
                       "begin the lines of the block with two more spaces");
    }
    reader_.Take();
    while (reader_.Peek().kind != TokenKind::kDedent && reader_.Peek().kind != TokenKind::kEnd &&
           !reader_.problems().full()) {
      Guarded([&] { Line(statements); });
    }
    if (reader_.Peek().kind == TokenKind::kDedent) reader_.Take();
    return statements;
  }

  void Line(std::vector<Statement>& statements) {
    if (reader_.Peek().kind == TokenKind::kIndent) {
      reader_.FailHere("a line as far to the right as the one above it");
    }
    if (reader_.Peek().Is("if")) {
      statements.push_back(If());
      return;
    }
    do {
      statements.push_back(reader_.Peek().Is("let") ? Let() : Assignment());
      if (++count_ > kMaxStatements) {
        reader_.problems().Fail(statements.back().span, "the text has more than 1000 statements");
      }
    } while (reader_.Takes(";") && !reader_.AtLineEnd());
    EndLine();
  }

  Statement Let() {
    const Span begin = reader_.Take().span;
    Statement let{.kind = StatementKind::kLet, .span = begin};
    let.name = reader_.ExpectName("a name behind 'let'");
    reader_.Expect("=", "and a value behind let " + let.name.word);
    let.value = ParseExpression(reader_);
    let.span = Join(begin, let.value->span);
    return let;
  }

  Statement Assignment() {
    Statement statement{.kind = StatementKind::kAssign, .span = reader_.Peek().span};
    if (reader_.Peek().Is("for") || reader_.Peek().Is("while")) {
      reader_.FailHere("a statement",
                       "a law has no loops; the lines of a block act on each of its rows");
    }
    if (reader_.Peek().Is("else")) reader_.FailHere("a statement", "'else' belongs below an 'if'");
    if (reader_.Peek().Is("each")) {
      reader_.FailHere("a statement",
                       "blocks are not nested; begin 'each' as far left as the "
                       "heading of this block");
    }
    statement.target = Target();
    const Token sign = reader_.Peek();
    if (sign.Is("+=")) {
      statement.kind = StatementKind::kAdd;
    } else if (sign.Is("-=")) {
      statement.kind = StatementKind::kSubtract;
    } else if (sign.Is("*=") || sign.Is("/=")) {
      const std::string target(reader_.text().substr(
          statement.target->span.begin, statement.target->span.end - statement.target->span.begin));
      reader_.FailHere("'=', '+=' or '-='",
                       "write " + target + " = " + target + " " + sign.word[0] + " …");
    } else if (!sign.Is("=")) {
      std::string hint;
      if (sign.kind == TokenKind::kName && !IsReserved(sign.word) && reader_.Peek(1).Is("=")) {
        hint = "a new name begins with let: let " + sign.word + " = …";
      }
      reader_.FailHere("'=', '+=' or '-='", hint);
    }
    reader_.Take();
    statement.value = ParseExpression(reader_);
    statement.span = Join(statement.target->span, statement.value->span);
    return statement;
  }

  ExpressionTree Target() {
    const Name name = reader_.ExpectName("a property, 'let' or 'if'");
    auto tree = std::make_unique<Expression>();
    tree->kind = ExpressionKind::kName;
    tree->span = name.span;
    tree->word = name.word;
    for (int members = 0; reader_.Takes("."); ++members) {
      const Name member = reader_.ExpectName("a property or a component behind the dot");
      if (members == 3) reader_.problems().Fail(member.span, "too many dots in one name");
      auto outer = std::make_unique<Expression>();
      outer->kind = ExpressionKind::kMember;
      outer->span = Join(tree->span, member.span);
      outer->word = member.word;
      outer->parts.push_back(std::move(tree));
      tree = std::move(outer);
    }
    return tree;
  }

  Statement If() {
    if (++depth_ > kMaxBlockDepth) {
      reader_.problems().Fail(reader_.Peek().span, "conditions are nested more than 16 deep");
    }
    const Span begin = reader_.Take().span;
    Statement statement{.kind = StatementKind::kIf, .span = begin};
    statement.value = ParseExpression(reader_);
    statement.span = Join(begin, statement.value->span);
    reader_.Expect(":", "behind the condition");
    statement.then = Body();
    if (reader_.Peek().Is("else")) {
      reader_.Take();
      if (reader_.Peek().Is("if")) {
        statement.otherwise.push_back(If());
      } else {
        reader_.Expect(":", "behind 'else'");
        statement.otherwise = Body();
      }
    }
    --depth_;
    return statement;
  }

  TokenReader reader_;
  int depth_ = 0;
  size_t count_ = 0;
};

}  // namespace

std::vector<LawTree> Parse(std::string_view text, Problems& problems) {
  return Parser(text, problems).Run();
}

bool IsFunction(std::string_view name) {
  return std::find(std::begin(kFunctions), std::end(kFunctions), name) != std::end(kFunctions);
}

std::vector<std::string> FunctionNames() { return {std::begin(kFunctions), std::end(kFunctions)}; }

bool IsReserved(std::string_view name) {
  return std::find(std::begin(kReserved), std::end(kReserved), name) != std::end(kReserved);
}

}  // namespace vesper::text
