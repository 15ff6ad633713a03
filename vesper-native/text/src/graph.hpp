// SPDX-License-Identifier: Apache-2.0
// Formulas as a graph of operations on numbers. Equal operations share one node, and constants are
// folded. A vector is three nodes.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <map>
#include <unordered_map>
#include <vector>

#include "problem.hpp"

namespace vesper::text {

enum class Operation : uint8_t {
  // Leaves.
  kConstant,   // value
  kParameter,  // index of the parameter
  kTime,       // time at the start of the step [s]
  kStep,       // dt [s]
  kStage,      // stage of the step
  kLoad,       // component of a property of a participant; see Load
  // Arithmetic.
  kAdd,
  kSubtract,
  kMultiply,
  kDivide,
  kNegate,
  kSqrt,
  kAbs,
  kMin,
  kMax,
  kFloor,
  // Functions.
  kExp,
  kLn,
  kSin,
  kCos,
  kTan,
  kAsin,
  kAcos,
  kAtan,
  kAtan2,
  kTanh,
  kPower,
  // Conditions: 1 or 0.
  kLess,
  kLessOrEqual,
  kEqual,
  kAnd,
  kOr,
  kNot,
  kSelect,  // a ? b : c
};

using NodeId = uint32_t;
inline constexpr NodeId kNoNode = UINT32_MAX;

/// A component of a property of a participant. A participant is a row that a formula uses: the row
/// of the block itself, a row that it refers to, one row of a pair, or the one row of the kind
/// `world`.
struct Load {
  uint16_t participant;
  uint16_t property;  // index in the law's list of properties
  uint16_t component;
  uint16_t reserved = 0;

  auto operator<=>(const Load&) const = default;
};

/// Numbers of the participants of a block.
inline constexpr uint16_t kOwnRow = 0;    // the row of the block
inline constexpr uint16_t kFirst = 1;     // first row of a pair or of references; further rows have
                                          // the next numbers
inline constexpr uint16_t kWorld = 0xff;  // the one row of kind world

struct Node {
  Operation operation;
  bool uniform;  // true if the value is the same for all rows
  Span span;     // part of the text that first produced this node
  NodeId a = kNoNode;
  NodeId b = kNoNode;
  NodeId c = kNoNode;
  double value = 0;    // value of a kConstant
  uint32_t index = 0;  // index of a kParameter
  Load load{};         // component that a kLoad reads
};

/// Thrown if a formula exceeds the maximum number of nodes.
struct TooLarge {};

class Graph {
 public:
  static constexpr size_t kMostNodes = 10000;
  static constexpr size_t kMostSteps = 100000;

  const Node& operator[](NodeId id) const { return nodes_[id]; }
  size_t size() const { return nodes_.size(); }
  /// Sets the part of the text to which later nodes belong.
  void At(Span span) { span_ = span; }

  NodeId Constant(double value);
  NodeId Parameter(uint32_t index);
  NodeId Leaf(Operation operation);
  NodeId LoadOf(const Load& load);
  NodeId Unary(Operation operation, NodeId a);
  NodeId Binary(Operation operation, NodeId a, NodeId b);
  NodeId Select(NodeId condition, NodeId a, NodeId b);

  NodeId Add(NodeId a, NodeId b) { return Binary(Operation::kAdd, a, b); }
  NodeId Subtract(NodeId a, NodeId b) { return Binary(Operation::kSubtract, a, b); }
  NodeId Multiply(NodeId a, NodeId b) { return Binary(Operation::kMultiply, a, b); }
  NodeId Divide(NodeId a, NodeId b) { return Binary(Operation::kDivide, a, b); }
  NodeId Negate(NodeId a) { return Unary(Operation::kNegate, a); }
  NodeId Sqrt(NodeId a) { return Unary(Operation::kSqrt, a); }
  /// Returns a^n for a whole n, by multiplications.
  NodeId WholePower(NodeId a, int n);

  bool IsConstant(NodeId id) const { return nodes_[id].operation == Operation::kConstant; }
  bool IsConstant(NodeId id, double value) const {
    return IsConstant(id) && nodes_[id].value == value;
  }

  /// Returns a copy of `root` in which some nodes are replaced.
  NodeId Substitute(NodeId root, const std::map<NodeId, NodeId>& replacements);

  /// Replaces divisions by multiplications with the inverse of the divisor. Does so if several
  /// divisions have the same divisor, or if the divisor is the same for all rows. Returns the new
  /// id of each node; kNoNode if no root depends on the node.
  std::vector<NodeId> ShareDivisions(const std::vector<NodeId*>& roots);

  /// Adds nodes for the derivatives of `root` with respect to the loads in `wanted`, and returns
  /// them.
  std::map<Load, NodeId> Gradient(NodeId root, const std::vector<Load>& wanted);

  /// Returns true if `root` does not depend on the time and has no steps, so that it is a
  /// continuous function of its loads wherever it is finite.
  bool IsContinuous(NodeId root) const;

  /// Returns the nodes on which `root` depends, and `root`, operands first.
  std::vector<NodeId> Ordered(NodeId root) const;

  /// Returns the loads on which `root` depends; ignores operands of the nodes `behind`.
  std::vector<Load> LoadsOf(NodeId root, std::initializer_list<NodeId> behind = {}) const;

 private:
  struct Hash {
    size_t operator()(const Node& node) const;
  };
  struct Same {
    bool operator()(const Node& a, const Node& b) const;
  };
  NodeId Intern(Node node);
  NodeId Folded(Operation operation, double a, double b);
  void Differentiate(NodeId root, NodeId adjoint, const std::vector<Load>& wanted,
                     std::map<Load, NodeId>& gradient, int depth);

  std::vector<Node> nodes_;
  std::unordered_map<Node, NodeId, Hash, Same> known_;
  Span span_{};
  size_t steps_ = 0;  // number of steps of differentiation so far
};

/// Computes an operation on doubles, with the same result as the evaluator.
double Compute(Operation operation, double a, double b, double c);

}  // namespace vesper::text
