// SPDX-License-Identifier: Apache-2.0
// A law text as a tree. It does not depend on the properties of a world and their units.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "problem.hpp"
#include "vesper/types.h"

namespace vesper::text {

enum class ExpressionKind {
  kNumber,       // number, with a unit or without
  kName,         // word
  kMember,       // parts[0] . word
  kCall,         // word(parts...)
  kNegative,     // - parts[0]
  kNot,          // not parts[0]
  kBinary,       // parts[0] word parts[1]; juxtaposition is "*"
  kTuple,        // (parts...), with a unit or without
  kLength,       // |parts[0]|
  kConditional,  // parts[0] if parts[1] else parts[2]
};

struct Expression {
  ExpressionKind kind;
  Span span;
  std::string word = {};
  double number = 0;
  std::optional<vesper_unit> unit = {};
  std::vector<std::string> unit_symbols =
      {};  // names inside the unit, which the author may have meant as variables
  std::vector<std::unique_ptr<Expression>> parts = {};
};
using ExpressionTree = std::unique_ptr<Expression>;

struct Name {
  std::string word;
  Span span;
};

enum class StatementKind { kLet, kAssign, kAdd, kSubtract, kIf };

struct Statement {
  StatementKind kind;
  Span span;
  Name name = {};                   // kLet
  ExpressionTree target = nullptr;  // kAssign, kAdd, kSubtract: a name, or a member of one
  ExpressionTree value = nullptr;   // kIf: the condition
  std::vector<Statement> then = {};
  std::vector<Statement> otherwise = {};
};

enum class BlockKind { kRows, kJoined, kPairs };

/// The ways in which an energy ends at the distance of `within`: not specified, cut off, shifted to
/// 0, or smoothly reduced to 0.
enum class Edge { kUnsaid, kCut, kShifted, kSmooth };

struct Block {
  BlockKind kind;
  Span span;  // span of the block's first line
  Name rows;  // kind of the rows, as written
  std::vector<Name> participants =
      {};  // kJoined: names of the references; kPairs: two names, or none
  ExpressionTree within = nullptr;
  std::optional<Name> distance = {};
  std::optional<Name> direction = {};
  Edge edge = Edge::kUnsaid;
  Span edge_span = {};
  std::optional<uint32_t> stage = {};  // stage from `at stage 1:`
  std::vector<Statement> statements = {};
};

struct ParameterTree {
  Name name;
  ExpressionTree value;
  ExpressionTree minimum = nullptr;
  ExpressionTree maximum = nullptr;
  std::string doc = {};
};

/// A declaration `each KIND has NAME in UNIT`, or `may have`.
struct Ownership {
  Name rows;
  Name name;
  uint32_t components = 1;
  std::optional<vesper_unit> unit = {};
  Span unit_span = {};
  ExpressionTree minimum = nullptr;  // null: no limits
  ExpressionTree maximum = nullptr;  // null: no greatest value
  Span limits_span = {};             // from `from` on
  bool optional = false;
};

/// A declaration `field NAME at PLACE = VALUE`.
struct FieldTree {
  Name name;
  Name place;
  ExpressionTree value;
  std::string doc = {};
};

struct LawTree {
  Name name;
  std::string doc;
  std::string version = "1.0.0";
  std::optional<Name> phase = {};
  uint32_t stages = 1;
  std::vector<ExpressionTree> weights = {};
  std::vector<ParameterTree> parameters = {};
  std::vector<Ownership> owned = {};
  std::vector<Statement> lets = {};
  std::vector<FieldTree> fields = {};
  std::vector<Block> blocks = {};
};

/// Parses a text; adds problems to `problems`. The result is complete only if there are none.
std::vector<LawTree> Parse(std::string_view text, Problems& problems);

/// Returns true for the name of a function, such as "sqrt".
bool IsFunction(std::string_view name);

/// Returns the names of all functions.
std::vector<std::string> FunctionNames();
/// Returns true for a reserved word, which cannot be a name.
bool IsReserved(std::string_view name);

}  // namespace vesper::text
