// SPDX-License-Identifier: Apache-2.0
// Checks of the units and kinds of values in expressions.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "checker.hpp"

namespace vesper::text {
namespace {

constexpr int kLargestPower = 64;  // largest exponent that is computed by multiplications; powers
                                   // with larger exponents are computed by logarithms

std::string KindOfValue(const Value& value) {
  if (value.condition) return "a condition";
  if (value.IsVector()) return "a vector";
  if (value.IsRotation()) return "a rotation";
  return "a number";
}

std::string KindAndUnit(const Value& value) {
  if (value.condition || value.IsRotation()) return KindOfValue(value);
  if (value.dimension.IsOne())
    return value.IsVector() ? "a vector of plain numbers" : "a plain number";
  return (value.IsVector() ? "a vector in " : "") + Describe(value.dimension);
}

/// Sets `twelfths` to 12 times the exponent. Returns false if this is not a small whole number.
bool Twelfths(double exponent, int& twelfths) {
  const double scaled = exponent * Dimension::kWhole;
  if (!(std::abs(scaled) < 1e6) || std::abs(scaled - std::round(scaled)) > 1e-9) return false;
  twelfths = static_cast<int>(std::round(scaled));
  return true;
}

}  // namespace

Value Checker::Number(NodeId node, const Dimension& dimension, Span span) const {
  Value value;
  value.dimension = dimension;
  value.node[0] = node;
  value.span = span;
  return value;
}

/// Returns a hint for a value in the place of a condition.
std::string Checker::ComparisonHint(const Value& value) const {
  const std::string source = Source(value.span);
  if (value.IsRotation()) return "compare one of its components, such as: " + source + ".w > 0";
  const std::string number = value.IsVector() ? "|" + source + "|" : source;
  const std::string unit = value.dimension.IsOne() ? "" : " " + UnitName(value.dimension);
  return "compare it with another value, such as: " + number + " > 1" + unit;
}

void Checker::RequireQuantity(const Value& value) {
  if (!value.condition) return;
  problems_.Fail(value.span, Quoted(value.span) + " is a condition, expected a value",
                 "write VALUE if " + Source(value.span) + " else VALUE");
}

void Checker::RequireNumber(const Value& value, const std::string& where) {
  RequireQuantity(value);
  if (value.components == 1) return;
  problems_.Fail(
      value.span,
      Quoted(value.span) + " is " + KindOfValue(value) + ", but " + where + " takes a number",
      value.IsVector() ? "write |" + Source(value.span) + "| for its length, or (" +
                             Source(value.span) + ").x for a component"
                       : "");
}

void Checker::RequireUnit(Value& value, const Dimension& expected, const std::string& what) {
  if (value.any_unit) value.dimension = expected;
  if (value.dimension == expected) return;
  std::string hint;
  if (value.dimension.IsOne() && graph_.IsConstant(value.node[0])) {
    hint = "write its unit: " + Source(value.span) + " " + UnitName(expected);
  } else {
    hint = FactorHint("it", value.dimension, expected);
  }
  problems_.Fail(value.span,
                 Quoted(value.span) + " is " + KindAndUnit(value) + ", but " + what + " is " +
                     Describe(expected),
                 hint);
}

/// Returns `c (w - v)` for the sum `c w - v`, if this sum would have one unit; otherwise nothing.
std::string Checker::Bracketed(const Expression& sum, const Value& left, const Value& right) {
  const Expression& product = *sum.parts[0];
  const Expression* first = &product;
  while (first->kind == ExpressionKind::kBinary && (first->word == "*" || first->word == "/")) {
    first = first->parts[0].get();
  }
  if (first == &product || left.components != right.components) return {};
  const Value factor = Evaluate(*first);
  if (factor.components != 1 || left.dimension / factor.dimension != right.dimension) return {};
  std::string rest = Source({first->span.end, product.span.end});
  rest.erase(0, rest.find_first_not_of(" *"));
  if (rest.starts_with("/") || rest.starts_with(")")) return {};
  return Source(first->span) + " (" + rest + " " + sum.word + " " + Source(right.span) + ")";
}

void Checker::RequireSameUnit(Value& left, Value& right, const std::string& what, Span span,
                              const std::string& better) {
  if (left.any_unit) left.dimension = right.dimension;
  if (right.any_unit) right.dimension = left.dimension;
  if (left.dimension == right.dimension) return;
  std::string hint;
  const auto is_bare = [&](const Value& value) {
    return value.dimension.IsOne() && value.components == 1 && graph_.IsConstant(value.node[0]);
  };
  if (is_bare(left) || is_bare(right)) {
    const Value& bare = is_bare(left) ? left : right;
    const Value& other = is_bare(left) ? right : left;
    hint = "if " + Source(bare.span) + " is meant in " + UnitName(other.dimension) + ", write " +
           Source(bare.span) + " " + UnitName(other.dimension);
  } else {
    hint = FactorHint(Quoted(left.span), left.dimension, right.dimension);
  }
  if (!better.empty()) hint = "if brackets are missing, write " + better;
  problems_.Fail(span,
                 Quoted(left.span) + " is " + KindAndUnit(left) + " and " + Quoted(right.span) +
                     " is " + KindAndUnit(right) + ": they cannot be " + what,
                 hint);
}

void Checker::CheckUnitSymbols(const Expression& tree) {
  for (const std::string& symbol : tree.unit_symbols) {
    const bool known = IsKnown(symbol) || failed_.contains(symbol);
    if (!known) continue;
    std::string number = Source(tree.span);
    if (tree.kind == ExpressionKind::kTuple) {
      number = number.substr(0, number.rfind(')') + 1);
    } else {
      number.erase(0, number.find_first_not_of('('));
      number = number.substr(0, number.find(' '));
    }
    problems_.Fail(tree.span, "'" + symbol + "' is a unit here, but also a name of this law",
                   "write " + number + " * " + symbol + " for the name, or call it otherwise");
  }
}

Value Checker::Evaluate(const Expression& tree) {
  graph_.At(tree.span);
  switch (tree.kind) {
    case ExpressionKind::kNumber:
      return EvaluateNumber(tree);
    case ExpressionKind::kName:
      return EvaluateName(tree);
    case ExpressionKind::kMember:
      return EvaluateMember(tree);
    case ExpressionKind::kCall:
      return EvaluateCall(tree);
    case ExpressionKind::kNegative: {
      Value value = Evaluate(*tree.parts[0]);
      RequireQuantity(value);
      graph_.At(tree.span);
      for (uint32_t i = 0; i < value.components; ++i) value.node[i] = graph_.Negate(value.node[i]);
      value.span = tree.span;
      return value;
    }
    case ExpressionKind::kNot: {
      Value value = Evaluate(*tree.parts[0]);
      if (!value.condition) {
        problems_.Fail(value.span,
                       Quoted(value.span) + " is " + KindAndUnit(value) +
                           ", but 'not' takes a condition such as r < 1 m",
                       ComparisonHint(value));
      }
      value.node[0] = graph_.Unary(Operation::kNot, value.node[0]);
      value.span = tree.span;
      return value;
    }
    case ExpressionKind::kBinary:
      return EvaluateBinary(tree);
    case ExpressionKind::kTuple:
      return EvaluateTuple(tree);
    case ExpressionKind::kLength: {
      Value value = Evaluate(*tree.parts[0]);
      RequireQuantity(value);
      graph_.At(tree.span);
      return LengthOf(value, tree.span);
    }
    case ExpressionKind::kConditional:
      return EvaluateConditional(tree);
  }
  return {};
}

Value Checker::EvaluateNumber(const Expression& tree) {
  CheckUnitSymbols(tree);
  double number = tree.number;
  Dimension dimension;
  if (tree.unit) {
    number *= tree.unit->scale;
    dimension = DimensionOf(*tree.unit);
  }
  if (!std::isfinite(number)) problems_.Fail(tree.span, "the number is too large in SI units");
  Value value = Number(graph_.Constant(number), dimension, tree.span);
  value.any_unit = number == 0 && !tree.unit;
  return value;
}

Value Checker::EvaluateName(const Expression& tree) {
  const std::string& name = tree.word;
  for (auto let = lets_.rbegin(); let != lets_.rend(); ++let) {
    if (let->first != name) continue;
    Value value = let->second;
    value.span = tree.span;
    return value;
  }
  for (const Parameter& parameter : parameters_) {
    if (parameter.name != name) continue;
    Value value = parameter.value;
    value.span = tree.span;
    uses_axes_ = uses_axes_ || value.IsVector();
    return value;
  }
  if (name == "dt") return Number(graph_.Leaf(Operation::kStep), kTime, tree.span);
  if (name == "time") return Number(graph_.Leaf(Operation::kTime), kTime, tree.span);
  if (name == "pi") return Number(graph_.Constant(std::numbers::pi), kNumber, tree.span);
  if (name == "stage") {
    uses_stage_ = true;
    return Number(graph_.Leaf(Operation::kStage), kNumber, tree.span);
  }
  for (const auto& [participant, kind] : participants_) {
    if (participant != name) continue;
    problems_.Fail(tree.span, "'" + name + "' is a whole row, expected a property of it",
                   "write " + name + ".position, for example");
  }
  if (block_ != nullptr && IsProperty(row_kind_, name)) {
    return ReadProperty(kOwnRow, Resolve(kOwnRow, name, tree.span), tree.span);
  }
  if (const uint32_t field = FindField(name); field != kNone) {
    return ReadProperty(kOwnRow, UseField(kOwnRow, field, tree.span), tree.span);
  }
  if (IsProperty(world_kind_, name)) {
    return ReadProperty(kWorld, Resolve(kWorld, name, tree.span), tree.span);
  }
  if (name == "energy" || name == "attraction" || name == "repulsion") {
    problems_.Fail(tree.span, "'" + name + "' can be set here, but not read");
  }
  FailUnknown(name, tree.span);
}

Value Checker::EvaluateMember(const Expression& tree) {
  const Expression& outer = *tree.parts[0];
  if (outer.kind == ExpressionKind::kName) {
    for (size_t i = 0; i < participants_.size(); ++i) {
      if (participants_[i].first != outer.word) continue;
      const auto participant = static_cast<uint16_t>(kFirst + i);
      return ReadProperty(participant, Resolve(participant, tree.word, tree.span), tree.span);
    }
    if (outer.word == "world") {
      return ReadProperty(kWorld, Resolve(kWorld, tree.word, tree.span), tree.span);
    }
  }
  const Value value = Evaluate(outer);
  RequireQuantity(value);
  const std::string_view names = value.IsRotation() ? "xyzw" : "xyz";
  const size_t component = tree.word.size() == 1 ? names.find(tree.word[0]) : std::string::npos;
  if (value.components == 1 || component == std::string::npos) {
    problems_.Fail(
        tree.span,
        Quoted(outer.span) + " is " + KindOfValue(value) + " and has no '" + tree.word + "'",
        value.components == 1 ? "" : "its components are x, y and z");
  }
  uses_axes_ = true;
  Value one = Number(value.node[component], value.dimension, tree.span);
  one.any_unit = value.any_unit;
  return one;
}

Value Checker::EvaluateBinary(const Expression& tree) {
  if (tree.word == "^") return EvaluatePower(tree);
  Value left = Evaluate(*tree.parts[0]);
  Value right = Evaluate(*tree.parts[1]);
  graph_.At(tree.span);
  if (tree.word == "and" || tree.word == "or") {
    for (const Value* value : {&left, &right}) {
      if (value->condition) continue;
      problems_.Fail(value->span,
                     Quoted(value->span) + " is " + KindAndUnit(*value) + ", but '" + tree.word +
                         "' takes conditions such as r < 1 m",
                     ComparisonHint(*value));
    }
    left.node[0] = graph_.Binary(tree.word == "and" ? Operation::kAnd : Operation::kOr,
                                 left.node[0], right.node[0]);
    left.span = tree.span;
    return left;
  }
  RequireQuantity(left);
  RequireQuantity(right);
  if (tree.word == "+" || tree.word == "-") return EvaluateSum(tree, left, right);
  if (tree.word == "/") return EvaluateQuotient(tree, left, right);
  if (tree.word == "*" || tree.word == "·" || tree.word == "×") {
    return EvaluateProduct(tree, left, right);
  }
  return EvaluateComparison(tree, left, right);
}

Value Checker::EvaluateSum(const Expression& tree, Value left, Value right) {
  const std::string what = tree.word == "+" ? "added" : "subtracted";
  const auto is_zero = [](const Value& value) { return value.any_unit && value.components == 1; };
  if (is_zero(left) && right.components == 3)
    left = {right.dimension, 3, false, true, {left.node[0], left.node[0], left.node[0]}, left.span};
  if (is_zero(right) && left.components == 3)
    right = {left.dimension, 3, false, true, {right.node[0], right.node[0], right.node[0]},
             right.span};
  if (left.components != right.components &&
      (left.dimension == right.dimension || left.any_unit || right.any_unit)) {
    const Value& vector = left.components > right.components ? left : right;
    problems_.Fail(tree.span,
                   Quoted(left.span) + " is " + KindAndUnit(left) + " and " + Quoted(right.span) +
                       " is " + KindAndUnit(right) + ": they cannot be " + what,
                   "write |" + Source(vector.span) +
                       "| for the length of the vector, or a vector (" + "x, y, z) for the number");
  }
  const bool same = left.any_unit || right.any_unit || left.dimension == right.dimension;
  RequireSameUnit(left, right, what, tree.span,
                  same ? std::string{} : Bracketed(tree, left, right));
  if (left.components != right.components) return left;
  const Operation operation = tree.word == "+" ? Operation::kAdd : Operation::kSubtract;
  Value sum = left;
  for (uint32_t i = 0; i < left.components; ++i) {
    sum.node[i] = graph_.Binary(operation, left.node[i], right.node[i]);
  }
  sum.any_unit = left.any_unit && right.any_unit;
  sum.span = tree.span;
  return sum;
}

NodeId Checker::DotOf(const Value& a, const Value& b) {
  NodeId sum = graph_.Multiply(a.node[0], b.node[0]);
  for (uint32_t i = 1; i < a.components; ++i) {
    sum = graph_.Add(sum, graph_.Multiply(a.node[i], b.node[i]));
  }
  return sum;
}

Value Checker::EvaluateProduct(const Expression& tree, const Value& left, const Value& right) {
  const Dimension dimension = left.dimension * right.dimension;
  if (!dimension.IsPossible()) problems_.Fail(tree.span, "the unit has an exponent beyond 100");
  Value product;
  product.dimension = dimension;
  product.span = tree.span;
  product.any_unit = left.any_unit || right.any_unit;
  if (left.IsVector() && right.IsVector()) {
    if (tree.word == "·") {
      product.node[0] = DotOf(left, right);
      return product;
    }
    if (tree.word == "×") {
      product.components = 3;
      for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t j = (i + 1) % 3, k = (i + 2) % 3;
        product.node[i] = graph_.Subtract(graph_.Multiply(left.node[j], right.node[k]),
                                          graph_.Multiply(left.node[k], right.node[j]));
      }
      return product;
    }
    problems_.Fail(tree.span,
                   "a product of the vectors " + Quoted(left.span) + " and " + Quoted(right.span) +
                       " can be a number or a vector",
                   "write dot(" + Source(left.span) + ", " + Source(right.span) + ") or cross(" +
                       Source(left.span) + ", " + Source(right.span) + ")");
  }
  if (left.IsRotation() || right.IsRotation()) {
    if (left.IsRotation() && right.IsRotation()) {
      product.components = 4;
      const auto& a = left.node;
      const auto& b = right.node;
      for (uint32_t i = 0; i < 3; ++i) {
        const uint32_t j = (i + 1) % 3, k = (i + 2) % 3;
        const NodeId cross =
            graph_.Subtract(graph_.Multiply(a[j], b[k]), graph_.Multiply(a[k], b[j]));
        product.node[i] =
            graph_.Add(graph_.Add(graph_.Multiply(a[3], b[i]), graph_.Multiply(b[3], a[i])), cross);
      }
      NodeId w = graph_.Multiply(a[3], b[3]);
      for (uint32_t i = 0; i < 3; ++i) w = graph_.Subtract(w, graph_.Multiply(a[i], b[i]));
      product.node[3] = w;
      return product;
    }
    problems_.Fail(tree.span, "a rotation is multiplied with rotations only",
                   "write rotate(q, v) to turn a vector");
  }
  if (tree.word == "×" && (left.IsVector() || right.IsVector())) {
    const Value& number = left.IsVector() ? right : left;
    problems_.Fail(tree.span,
                   "'×' between vectors is the cross product, but " + Quoted(number.span) + " is " +
                       KindAndUnit(number),
                   "write * to multiply a vector with a number");
  }
  const Value& scalar = left.components == 1 ? left : right;
  const Value& other = left.components == 1 ? right : left;
  product.components = other.components;
  for (uint32_t i = 0; i < other.components; ++i) {
    product.node[i] = graph_.Multiply(scalar.node[0], other.node[i]);
  }
  return product;
}

Value Checker::EvaluateQuotient(const Expression& tree, const Value& left, const Value& right) {
  RequireNumber(right, "the part below the line of a division");
  if (graph_.IsConstant(right.node[0], 0)) problems_.Fail(tree.span, "a division by zero");
  Value quotient = left;
  quotient.dimension = left.dimension / right.dimension;
  if (!quotient.dimension.IsPossible()) {
    problems_.Fail(tree.span, "the unit has an exponent beyond 100");
  }
  for (uint32_t i = 0; i < left.components; ++i) {
    quotient.node[i] = graph_.Divide(left.node[i], right.node[0]);
  }
  quotient.span = tree.span;
  return quotient;
}

Value Checker::EvaluatePower(const Expression& tree) {
  Value base = Evaluate(*tree.parts[0]);
  RequireQuantity(base);
  Value exponent = Evaluate(*tree.parts[1]);
  graph_.At(tree.span);
  RequireNumber(exponent, "an exponent");
  if (!exponent.dimension.IsOne()) {
    problems_.Fail(exponent.span,
                   "the exponent " + Quoted(exponent.span) + " is " + KindAndUnit(exponent) +
                       ", expected a plain number",
                   "divide it by a constant in " + UnitName(exponent.dimension));
  }
  const bool constant = graph_.IsConstant(exponent.node[0]);
  const double n = constant ? graph_[exponent.node[0]].value : 0;
  const bool whole = constant && std::abs(n) <= kLargestPower && n == std::round(n);
  if (base.components != 1) {
    if (base.IsVector() && whole && n == 2) {
      return Number(DotOf(base, base), base.dimension * base.dimension, tree.span);
    }
    problems_.Fail(
        tree.span,
        Quoted(base.span) + " is " + KindOfValue(base) + ": only its square has a meaning",
        "write |" + Source(base.span) + "| for its length");
  }
  Dimension dimension;
  int twelfths = 0;
  if (!base.dimension.IsOne()) {
    bool exact = false;
    if (constant && Twelfths(n, twelfths)) dimension = Power(base.dimension, twelfths, exact);
    if (!exact) {
      problems_.Fail(tree.span,
                     Quoted(base.span) + " is " + KindAndUnit(base) +
                         ": its exponent must be a number such as 2 or 1/2, because it changes "
                         "the unit",
                     "divide " + Source(base.span) + " by a constant of the same unit first");
    }
    if (!dimension.IsPossible()) problems_.Fail(tree.span, "the unit has an exponent beyond 100");
  }
  NodeId node;
  if (whole) {
    node = graph_.WholePower(base.node[0], static_cast<int>(n));
  } else if (constant && n == 0.5) {
    node = graph_.Sqrt(base.node[0]);
  } else if (constant && std::abs(n) <= kLargestPower && 2 * n == std::round(2 * n)) {
    node = graph_.WholePower(graph_.Sqrt(base.node[0]), static_cast<int>(2 * n));
  } else {
    node = graph_.Binary(Operation::kPower, base.node[0], exponent.node[0]);
  }
  return Number(node, dimension, tree.span);
}

Value Checker::EvaluateComparison(const Expression& tree, const Value& left, const Value& right) {
  RequireNumber(left, "a comparison");
  RequireNumber(right, "a comparison");
  Value a = left, b = right;
  RequireSameUnit(a, b, "compared", tree.span);
  Value value;
  value.condition = true;
  value.span = tree.span;
  if (tree.word == "<") value.node[0] = graph_.Binary(Operation::kLess, a.node[0], b.node[0]);
  if (tree.word == ">") value.node[0] = graph_.Binary(Operation::kLess, b.node[0], a.node[0]);
  if (tree.word == "<=") {
    value.node[0] = graph_.Binary(Operation::kLessOrEqual, a.node[0], b.node[0]);
  }
  if (tree.word == ">=") {
    value.node[0] = graph_.Binary(Operation::kLessOrEqual, b.node[0], a.node[0]);
  }
  if (tree.word == "=" || tree.word == "!=") {
    value.node[0] = graph_.Binary(Operation::kEqual, a.node[0], b.node[0]);
    if (tree.word == "!=") value.node[0] = graph_.Unary(Operation::kNot, value.node[0]);
  }
  return value;
}

Value Checker::EvaluateTuple(const Expression& tree) {
  if (tree.parts.size() != 3) {
    problems_.Fail(tree.span,
                   "a vector has three components, found " + std::to_string(tree.parts.size()),
                   "write (x, y, z); y points up");
  }
  CheckUnitSymbols(tree);
  Value vector;
  vector.components = 3;
  vector.any_unit = true;
  vector.span = tree.span;
  bool has_dimension = false;
  Value first;
  for (uint32_t i = 0; i < 3; ++i) {
    Value part = Evaluate(*tree.parts[i]);
    RequireNumber(part, "a component of a vector");
    if (tree.unit && !part.dimension.IsOne()) {
      problems_.Fail(part.span, Quoted(part.span) + " has a unit, and so has the vector",
                     "write the unit once, behind the bracket");
    }
    if (!part.any_unit && has_dimension && part.dimension != first.dimension) {
      Value again = part;
      RequireSameUnit(first, again, "components of one vector", tree.span);
    }
    if (!part.any_unit && !has_dimension) {
      first = part;
      vector.dimension = part.dimension;
      has_dimension = true;
    }
    vector.any_unit = vector.any_unit && part.any_unit;
    vector.node[i] = part.node[0];
    uses_axes_ = uses_axes_ || !graph_.IsConstant(part.node[0], 0);
  }
  if (tree.unit) {
    vector.dimension = DimensionOf(*tree.unit);
    vector.any_unit = false;
    const NodeId scale = graph_.Constant(tree.unit->scale);
    for (uint32_t i = 0; i < 3; ++i) vector.node[i] = graph_.Multiply(scale, vector.node[i]);
  }
  return vector;
}

Value Checker::EvaluateConditional(const Expression& tree) {
  Value first = Evaluate(*tree.parts[0]);
  const Value condition = Evaluate(*tree.parts[1]);
  Value second = Evaluate(*tree.parts[2]);
  graph_.At(tree.span);
  if (!condition.condition) {
    problems_.Fail(condition.span,
                   Quoted(condition.span) + " is " + KindAndUnit(condition) +
                       ", expected a condition such as r < 1 m",
                   ComparisonHint(condition));
  }
  RequireQuantity(first);
  RequireQuantity(second);
  if (first.any_unit && first.components == 1 && second.components == 3) {
    first.node[1] = first.node[2] = first.node[0];
    first.components = 3;
  }
  if (second.any_unit && second.components == 1 && first.components == 3) {
    second.node[1] = second.node[2] = second.node[0];
    second.components = 3;
  }
  if (first.components != second.components) {
    problems_.Fail(tree.span, Quoted(first.span) + " is " + KindOfValue(first) + " and " +
                                  Quoted(second.span) + " is " + KindOfValue(second) +
                                  ": a choice needs two of the same kind");
  }
  RequireSameUnit(first, second, "the two values of a choice", tree.span);
  Value value = first;
  for (uint32_t i = 0; i < first.components; ++i) {
    value.node[i] = graph_.Select(condition.node[0], first.node[i], second.node[i]);
  }
  value.any_unit = first.any_unit && second.any_unit;
  value.span = tree.span;
  return value;
}

Value Checker::LengthOf(const Value& vector, Span span) {
  if (vector.components == 1) {
    return Number(graph_.Unary(Operation::kAbs, vector.node[0]), vector.dimension, span);
  }
  return Number(graph_.Sqrt(DotOf(vector, vector)), vector.dimension, span);
}

/// Returns a vector divided by its length; zero for the zero vector.
Value Checker::DirectionOf(const Value& vector, Span span) {
  const NodeId length = graph_.Sqrt(DotOf(vector, vector));
  const NodeId zero = graph_.Constant(0);
  const NodeId inverse = graph_.Select(graph_.Binary(Operation::kEqual, length, zero), zero,
                                       graph_.Divide(graph_.Constant(1), length));
  Value direction = vector;
  direction.dimension = kNumber;
  for (uint32_t i = 0; i < vector.components; ++i) {
    direction.node[i] = graph_.Multiply(inverse, vector.node[i]);
  }
  direction.span = span;
  return direction;
}

/// Rotates a vector by a unit quaternion xyzw: v + 2 q × (q × v + w v).
Value Checker::Rotated(const Value& rotation, const Value& vector, bool back, Span span) {
  const auto cross = [&](const std::array<NodeId, 4>& a, const std::array<NodeId, 4>& b) {
    std::array<NodeId, 4> product{kNoNode, kNoNode, kNoNode, kNoNode};
    for (uint32_t i = 0; i < 3; ++i) {
      const uint32_t j = (i + 1) % 3, k = (i + 2) % 3;
      product[i] = graph_.Subtract(graph_.Multiply(a[j], b[k]), graph_.Multiply(a[k], b[j]));
    }
    return product;
  };
  const NodeId w = back ? graph_.Negate(rotation.node[3]) : rotation.node[3];
  std::array<NodeId, 4> inner = cross(rotation.node, vector.node);
  for (uint32_t i = 0; i < 3; ++i) {
    inner[i] = graph_.Add(inner[i], graph_.Multiply(w, vector.node[i]));
  }
  const std::array<NodeId, 4> outer = cross(rotation.node, inner);
  Value turned = vector;
  for (uint32_t i = 0; i < 3; ++i) {
    turned.node[i] = graph_.Add(vector.node[i], graph_.Multiply(graph_.Constant(2), outer[i]));
  }
  turned.span = span;
  return turned;
}

}  // namespace vesper::text
