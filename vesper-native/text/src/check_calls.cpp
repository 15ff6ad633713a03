// SPDX-License-Identifier: Apache-2.0
// The functions of the language, such as sqrt.
#include <algorithm>
#include <iterator>

#include "checker.hpp"

namespace vesper::text {
namespace {

/// The rules for the unit of a function's result, which follows from the units of its arguments.
enum class Units { kPlain, kSame, kSqrt, kIgnored, kAngle };

struct Function {
  std::string_view name;
  size_t arguments;
  Units units;
  Operation operation;
};

constexpr Function kFunctions[] = {
    {"sqrt", 1, Units::kSqrt, Operation::kSqrt},    {"abs", 1, Units::kSame, Operation::kAbs},
    {"sign", 1, Units::kIgnored, Operation::kLess}, {"floor", 1, Units::kPlain, Operation::kFloor},
    {"min", 2, Units::kSame, Operation::kMin},      {"max", 2, Units::kSame, Operation::kMax},
    {"clamp", 3, Units::kSame, Operation::kMin},    {"sin", 1, Units::kPlain, Operation::kSin},
    {"cos", 1, Units::kPlain, Operation::kCos},     {"tan", 1, Units::kPlain, Operation::kTan},
    {"asin", 1, Units::kPlain, Operation::kAsin},   {"acos", 1, Units::kPlain, Operation::kAcos},
    {"atan", 1, Units::kPlain, Operation::kAtan},   {"atan2", 2, Units::kAngle, Operation::kAtan2},
    {"exp", 1, Units::kPlain, Operation::kExp},     {"ln", 1, Units::kPlain, Operation::kLn},
    {"log10", 1, Units::kPlain, Operation::kLn},    {"tanh", 1, Units::kPlain, Operation::kTanh},
    {"sinh", 1, Units::kPlain, Operation::kExp},    {"cosh", 1, Units::kPlain, Operation::kExp}};

struct VectorFunction {
  std::string_view name;
  size_t arguments;
  const char* form;
};

constexpr VectorFunction kVectorFunctions[] = {
    {"dot", 2, "dot(vector, vector)"},
    {"cross", 2, "cross(vector, vector)"},
    {"direction", 1, "direction(vector)"},
    {"rotate", 2, "rotate(rotation, vector)"},
    {"unrotate", 2, "unrotate(rotation, vector)"},
    {"quaternion", 2, "quaternion(axis, angle)"},
};

}  // namespace

Value Checker::EvaluateCall(const Expression& tree) {
  std::vector<Value> arguments;
  for (const ExpressionTree& part : tree.parts) {
    arguments.push_back(Evaluate(*part));
    RequireQuantity(arguments.back());
  }
  graph_.At(tree.span);
  const bool on_vectors =
      std::any_of(std::begin(kVectorFunctions), std::end(kVectorFunctions),
                  [&](const VectorFunction& function) { return function.name == tree.word; });
  return on_vectors ? CallOnVectors(tree, arguments) : CallOnNumbers(tree, arguments);
}

Value Checker::CallOnNumbers(const Expression& tree, std::vector<Value>& arguments) {
  const auto& function =
      *std::find_if(std::begin(kFunctions), std::end(kFunctions),
                    [&](const Function& known) { return known.name == tree.word; });
  const bool any_number = tree.word == "min" || tree.word == "max";
  if (any_number ? arguments.size() < 2 : arguments.size() != function.arguments) {
    problems_.Fail(tree.span, tree.word + " takes " + std::to_string(function.arguments) +
                                  (any_number ? " or more" : "") + " values, found " +
                                  std::to_string(arguments.size()));
  }
  if (tree.word == "abs" && arguments[0].IsVector()) return LengthOf(arguments[0], tree.span);
  for (Value& argument : arguments) {
    RequireNumber(argument, tree.word);
    if (function.units != Units::kPlain || argument.dimension.IsOne()) continue;
    std::string hint = "divide it by a constant in " + UnitName(argument.dimension);
    problems_.Fail(argument.span,
                   Quoted(argument.span) + " is " + Describe(argument.dimension) + ", but " +
                       tree.word + " takes a plain number",
                   hint);
  }
  for (size_t i = 1; i < arguments.size(); ++i) {
    RequireSameUnit(arguments[0], arguments[i], "arguments of one " + tree.word, tree.span);
  }
  const NodeId a = arguments[0].node[0];
  Value value = Number(a, arguments[0].dimension, tree.span);
  const NodeId zero = graph_.Constant(0), one = graph_.Constant(1);
  if (tree.word == "min" || tree.word == "max") {
    for (size_t i = 1; i < arguments.size(); ++i) {
      value.node[0] = graph_.Binary(function.operation, value.node[0], arguments[i].node[0]);
    }
    return value;
  }
  if (tree.word == "clamp") {
    value.node[0] =
        graph_.Binary(Operation::kMin, graph_.Binary(Operation::kMax, a, arguments[1].node[0]),
                      arguments[2].node[0]);
    return value;
  }
  if (tree.word == "sign") {
    value.dimension = kNumber;
    value.node[0] = graph_.Select(
        graph_.Binary(Operation::kLess, zero, a), one,
        graph_.Select(graph_.Binary(Operation::kLess, a, zero), graph_.Constant(-1), zero));
    return value;
  }
  if (tree.word == "log10") {
    value.node[0] =
        graph_.Multiply(graph_.Unary(Operation::kLn, a), graph_.Constant(0.43429448190325182765));
    return value;
  }
  if (tree.word == "sinh" || tree.word == "cosh") {
    const NodeId grown = graph_.Unary(Operation::kExp, a);
    const NodeId shrunk = graph_.Unary(Operation::kExp, graph_.Negate(a));
    value.node[0] =
        graph_.Multiply(graph_.Constant(0.5), tree.word == "sinh" ? graph_.Subtract(grown, shrunk)
                                                                  : graph_.Add(grown, shrunk));
    return value;
  }
  if (function.arguments == 2) {
    value.node[0] = graph_.Binary(function.operation, a, arguments[1].node[0]);
  } else {
    value.node[0] = graph_.Unary(function.operation, a);
  }
  if (function.units == Units::kAngle) value.dimension = kNumber;
  if (function.units == Units::kSqrt) {
    bool exact = false;
    value.dimension = Power(arguments[0].dimension, Dimension::kWhole / 2, exact);
    if (!exact) {
      problems_.Fail(tree.span, "the root of " + UnitName(arguments[0].dimension) + " is no unit");
    }
  }
  return value;
}

Value Checker::CallOnVectors(const Expression& tree, std::vector<Value>& arguments) {
  const auto& function =
      *std::find_if(std::begin(kVectorFunctions), std::end(kVectorFunctions),
                    [&](const VectorFunction& known) { return known.name == tree.word; });
  const auto fits = [&](size_t i, uint32_t components) {
    return arguments[i].components == components;
  };
  bool right = arguments.size() == function.arguments;
  if (right) {
    if (tree.word == "rotate" || tree.word == "unrotate") {
      right = fits(0, 4) && fits(1, 3);
    } else if (tree.word == "quaternion") {
      right = fits(0, 3) && fits(1, 1);
    } else if (tree.word == "direction") {
      right = fits(0, 3);
    } else {
      right = fits(0, 3) && fits(1, 3);
    }
  }
  if (!right) {
    std::string found;
    for (const Value& argument : arguments) {
      found += (found.empty() ? "" : ", ") + std::string(argument.IsVector()     ? "a vector"
                                                         : argument.IsRotation() ? "a rotation"
                                                                                 : "a number");
    }
    problems_.Fail(tree.span, "found " + tree.word + "(" + found + "), expected " + function.form);
  }
  Value product;
  product.span = tree.span;
  if (tree.word == "dot" || tree.word == "cross") {
    Expression as_sign{.kind = ExpressionKind::kBinary, .span = tree.span};
    as_sign.word = tree.word == "dot" ? "·" : "×";
    return EvaluateProduct(as_sign, arguments[0], arguments[1]);
  }
  if (tree.word == "direction") return DirectionOf(arguments[0], tree.span);
  if (tree.word == "quaternion") {
    RequireUnit(arguments[1], kNumber, "an angle");
    const NodeId half = graph_.Multiply(graph_.Constant(0.5), arguments[1].node[0]);
    const Value axis = DirectionOf(arguments[0], tree.span);
    product.components = 4;
    for (uint32_t i = 0; i < 3; ++i) {
      product.node[i] = graph_.Multiply(graph_.Unary(Operation::kSin, half), axis.node[i]);
    }
    product.node[3] = graph_.Unary(Operation::kCos, half);
    return product;
  }
  return Rotated(arguments[0], arguments[1], tree.word == "unrotate", tree.span);
}

}  // namespace vesper::text
