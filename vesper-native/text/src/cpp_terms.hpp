// SPDX-License-Identifier: Apache-2.0
// Formulas as terms on numbers and vectors, recovered from a graph of operations on numbers.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "law_code.hpp"

namespace vesper::text {

enum class TermKind : uint8_t {
  kConstant,   // value
  kParameter,  // index; a vector: the parameters index, index + 1, index + 2
  kTime,
  kStep,
  kStage,
  kLoad,       // a number, a whole vector, or one component of an array
  kComponent,  // component `load.component` of the vector parts[0]
  kOperation,  // operation on numbers
  kSum,        // a sum of vectors; the terms up to kCross are vectors, too
  kDifference,
  kNegative,
  kScaled,  // number parts[0] times vector parts[1]
  kChoice,  // parts[0] ? parts[1] : parts[2]
  kCross,
  kDot,     // a number
  kLength,  // a number
  kVector,  // a vector made of three numbers
};

using TermId = uint32_t;

struct Term {
  TermKind kind;
  bool vector = false;
  bool condition = false;
  bool uniform = false;  // the same for all rows
  Operation operation = Operation::kConstant;
  std::vector<TermId> parts = {};
  double value = 0;
  uint32_t index = 0;
  Load load{};
  std::string name = {};  // name in the text, if there is one

  bool IsLeaf() const { return parts.empty(); }
};

/// The terms of one pass. Computing a term gives the same bits as computing its nodes, because
/// terms at most exchange the operands of a sum or product of two numbers.
class Terms {
 public:
  Terms(const LawCode& law, const PassCode& pass);

  const Term& operator[](TermId id) const { return terms_[id]; }
  size_t size() const { return terms_.size(); }
  TermId OfNumber(NodeId node);
  TermId OfVector(const std::array<NodeId, 3>& nodes);

 private:
  using Nodes = std::array<NodeId, 3>;

  TermId Add(Term term);
  TermId MakeNumber(NodeId node);
  TermId MakeVector(const Nodes& nodes);
  TermId OfComponents(const Nodes& nodes);
  bool IsWholeColumn(const Nodes& nodes) const;
  bool IsWholeParameter(const Nodes& nodes) const;
  /// Returns true if the nodes have the same form, so that they may be components of one vector.
  bool Alike(NodeId a, NodeId b, int depth) const;
  /// Splits sums or differences of three nodes into their left and right operands.
  void Split(const Nodes& nodes, Nodes& left, Nodes& right) const;
  bool FindScalar(const Nodes& nodes, NodeId& scalar, Nodes& vector) const;
  bool FindCross(const Nodes& nodes, Nodes& a, Nodes& b);
  bool FindDot(NodeId node, Nodes& a, Nodes& b);
  /// Returns true if three nodes are a column, a parameter or a named value, or an operation on
  /// vectors.
  bool IsVector(const Nodes& nodes);
  bool IsOperation(const Nodes& nodes);

  const LawCode& law_;
  const Graph& graph_;
  std::vector<Term> terms_;
  std::map<NodeId, TermId> numbers_;
  std::map<Nodes, TermId> vectors_;
  std::map<NodeId, std::string> number_names_;
  std::map<Nodes, std::string> vector_names_;
  std::map<NodeId, std::pair<Nodes, uint16_t>> components_;  // components of named vectors
  std::map<Nodes, bool>
      operations_;  // named vectors that are known; false also while they are made
};

}  // namespace vesper::text
