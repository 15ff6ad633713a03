// SPDX-License-Identifier: Apache-2.0
#include "cpp_terms.hpp"

#include <algorithm>
#include <utility>

namespace vesper::text {
namespace {

bool IsConditionOperation(Operation operation) {
  switch (operation) {
    case Operation::kLess:
    case Operation::kLessOrEqual:
    case Operation::kEqual:
    case Operation::kAnd:
    case Operation::kOr:
    case Operation::kNot:
      return true;
    default:
      return false;
  }
}

}  // namespace

Terms::Terms(const LawCode& law, const PassCode& pass) : law_(law), graph_(law.graph) {
  for (const NamedValue& named : pass.names) {
    const auto end = named.node.begin() + named.components;
    if (std::find(named.node.begin(), end, kNoNode) != end) continue;
    if (named.components == 1) {
      if (!graph_.IsConstant(named.node[0])) number_names_.try_emplace(named.node[0], named.name);
    } else if (named.components == 3) {
      const Nodes nodes{named.node[0], named.node[1], named.node[2]};
      vector_names_.try_emplace(nodes, named.name);
      for (uint16_t k = 0; k < 3; ++k) {
        if (graph_[nodes[k]].a != kNoNode) components_.try_emplace(nodes[k], nodes, k);
      }
    }
  }
}

TermId Terms::Add(Term term) {
  terms_.push_back(std::move(term));
  return static_cast<TermId>(terms_.size() - 1);
}

// --- numbers ----------------------------------------------------------------------------------

TermId Terms::OfNumber(NodeId node) {
  if (const auto known = numbers_.find(node); known != numbers_.end()) return known->second;
  TermId made = 0;
  const auto component = components_.find(node);
  const bool is_component = component != components_.end() && !graph_[node].uniform &&
                            !number_names_.contains(node) && IsOperation(component->second.first);
  if (const auto known = numbers_.find(node); known != numbers_.end()) return known->second;
  if (is_component) {
    Term term{.kind = TermKind::kComponent};
    term.parts = {OfVector(component->second.first)};
    term.load.component = component->second.second;
    made = Add(std::move(term));
  } else {
    made = MakeNumber(node);
  }
  if (const auto name = number_names_.find(node); name != number_names_.end()) {
    terms_[made].name = name->second;
  }
  numbers_[node] = made;
  return made;
}

TermId Terms::MakeNumber(NodeId id) {
  const Node& node = graph_[id];
  Term term{.kind = TermKind::kOperation, .uniform = node.uniform, .operation = node.operation};
  switch (node.operation) {
    case Operation::kConstant:
      term.kind = TermKind::kConstant;
      term.value = node.value;
      return Add(std::move(term));
    case Operation::kParameter:
      term.kind = TermKind::kParameter;
      term.index = node.index;
      return Add(std::move(term));
    case Operation::kTime:
    case Operation::kStep:
    case Operation::kStage:
      term.kind = node.operation == Operation::kTime   ? TermKind::kTime
                  : node.operation == Operation::kStep ? TermKind::kStep
                                                       : TermKind::kStage;
      return Add(std::move(term));
    case Operation::kLoad:
      term.kind = TermKind::kLoad;
      term.load = node.load;
      return Add(std::move(term));
    default:
      break;
  }
  Nodes a, b;
  if (!node.uniform && FindDot(id, a, b)) {
    term.kind = TermKind::kDot;
    term.parts = {OfVector(a), OfVector(b)};
    return Add(std::move(term));
  }
  if (!node.uniform && node.operation == Operation::kSqrt && FindDot(node.a, a, b) && a == b) {
    term.kind = TermKind::kLength;
    term.parts = {OfVector(a)};
    return Add(std::move(term));
  }
  term.condition = IsConditionOperation(node.operation);
  for (const NodeId operand : {node.a, node.b, node.c}) {
    if (operand != kNoNode) term.parts.push_back(OfNumber(operand));
  }
  return Add(std::move(term));
}

bool Terms::FindDot(NodeId id, Nodes& a, Nodes& b) {
  const auto is = [&](NodeId node, Operation operation) {
    return graph_[node].operation == operation;
  };
  const Node& outer = graph_[id];
  if (outer.operation != Operation::kAdd) return false;
  for (const auto& [pair, last] : {std::pair(outer.a, outer.b), std::pair(outer.b, outer.a)}) {
    if (!is(pair, Operation::kAdd) || !is(last, Operation::kMultiply)) continue;
    const Node& inner = graph_[pair];
    if (!is(inner.a, Operation::kMultiply) || !is(inner.b, Operation::kMultiply)) continue;
    for (const Nodes& products : {Nodes{inner.a, inner.b, last}, Nodes{inner.b, inner.a, last}}) {
      for (uint32_t swaps = 0; swaps < 4; ++swaps) {
        for (uint32_t k = 0; k < 3; ++k) {
          const Node& product = graph_[products[k]];
          const bool swap = k > 0 && (swaps >> (k - 1) & 1) != 0;
          a[k] = swap ? product.b : product.a;
          b[k] = swap ? product.a : product.b;
        }
        if (IsVector(a) && IsVector(b)) return true;
      }
    }
  }
  return false;
}

// --- vectors ----------------------------------------------------------------------------------

TermId Terms::OfVector(const Nodes& nodes) {
  if (const auto known = vectors_.find(nodes); known != vectors_.end()) return known->second;
  const TermId made = MakeVector(nodes);
  if (const auto name = vector_names_.find(nodes); name != vector_names_.end()) {
    terms_[made].name = name->second;
  }
  vectors_[nodes] = made;
  return made;
}

bool Terms::IsWholeColumn(const Nodes& nodes) const {
  for (uint16_t k = 0; k < 3; ++k) {
    const Node& node = graph_[nodes[k]];
    const Load& first = graph_[nodes[0]].load;
    if (node.operation != Operation::kLoad || node.load.component != k ||
        node.load.participant != first.participant || node.load.property != first.property ||
        law_.properties[node.load.property].components != 3) {
      return false;
    }
  }
  return true;
}

bool Terms::IsWholeParameter(const Nodes& nodes) const {
  for (uint32_t k = 0; k < 3; ++k) {
    const Node& node = graph_[nodes[k]];
    if (node.operation != Operation::kParameter || node.index != graph_[nodes[0]].index + k ||
        !law_.parameters[node.index].name.ends_with(std::string("_") + "xyz"[k])) {
      return false;
    }
  }
  return true;
}

bool Terms::IsVector(const Nodes& nodes) {
  if (IsWholeColumn(nodes) || IsWholeParameter(nodes) || vector_names_.contains(nodes)) return true;
  if (!Alike(nodes[0], nodes[1], 0) || !Alike(nodes[0], nodes[2], 0)) return false;
  const Operation operation = graph_[nodes[0]].operation;
  if (operation == Operation::kLoad || operation == Operation::kConstant) return false;
  return terms_[OfVector(nodes)].kind != TermKind::kVector;
}

/// Returns true if a named value is an operation on vectors. Its components can then be taken from
/// the vector. Otherwise the value consists of three numbers, which are computed first.
bool Terms::IsOperation(const Nodes& nodes) {
  const auto [known, is_new] = operations_.try_emplace(nodes, false);
  if (is_new) {
    const bool found = terms_[OfVector(nodes)].kind != TermKind::kVector;
    operations_[nodes] = found;
    return found;
  }
  return known->second;
}

bool Terms::Alike(NodeId a, NodeId b, int depth) const {
  constexpr int kDeepest = 4;
  if (a == b || depth == kDeepest) return true;
  const Node& first = graph_[a];
  const Node& second = graph_[b];
  if (first.operation != second.operation || first.uniform != second.uniform) return false;
  if (first.operation == Operation::kLoad) {
    return first.load.participant == second.load.participant &&
           first.load.property == second.load.property;
  }
  if (first.a == kNoNode) return true;
  if (first.b == kNoNode) return Alike(first.a, second.a, depth + 1);
  const bool straight = Alike(first.a, second.a, depth + 1) && Alike(first.b, second.b, depth + 1);
  if (first.c != kNoNode) return straight && Alike(first.c, second.c, depth + 1);
  const bool commutes =
      first.operation == Operation::kAdd || first.operation == Operation::kMultiply;
  return straight ||
         (commutes && Alike(first.a, second.b, depth + 1) && Alike(first.b, second.a, depth + 1));
}

void Terms::Split(const Nodes& nodes, Nodes& left, Nodes& right) const {
  for (uint32_t k = 0; k < 3; ++k) {
    const Node& node = graph_[nodes[k]];
    left[k] = node.a;
    right[k] = node.b;
    if (k == 0 || node.operation != Operation::kAdd) continue;
    // The operands of a sum are sorted by their ids, so they may be exchanged.
    const bool straight = Alike(left[0], left[k], 0) && Alike(right[0], right[k], 0);
    if (!straight) std::swap(left[k], right[k]);
  }
}

bool Terms::FindScalar(const Nodes& nodes, NodeId& scalar, Nodes& vector) const {
  const Node& first = graph_[nodes[0]];
  for (const NodeId candidate : {first.a, first.b}) {
    bool common = true;
    for (uint32_t k = 0; k < 3; ++k) {
      const Node& node = graph_[nodes[k]];
      if (node.a != candidate && node.b != candidate) {
        common = false;
        break;
      }
      vector[k] = node.a == candidate ? node.b : node.a;
    }
    if (!common) continue;
    scalar = candidate;
    return true;
  }
  return false;
}

bool Terms::FindCross(const Nodes& nodes, Nodes& a, Nodes& b) {
  std::array<std::array<const Node*, 2>, 3> products;
  for (uint32_t k = 0; k < 3; ++k) {
    const Node& node = graph_[nodes[k]];
    if (node.operation != Operation::kSubtract) return false;
    products[k] = {&graph_[node.a], &graph_[node.b]};
    for (const Node* product : products[k]) {
      if (product->operation != Operation::kMultiply) return false;
    }
  }
  // The components of a cross product are x = a1 b2 - a2 b1, y = a2 b0 - a0 b2 and z = a0 b1 - a1
  // b0.
  const auto other = [](const Node& product, NodeId factor) {
    return product.a == factor ? product.b : product.b == factor ? product.a : kNoNode;
  };
  for (const NodeId a1 : {products[0][0]->a, products[0][0]->b}) {
    for (const NodeId a2 : {products[0][1]->a, products[0][1]->b}) {
      const NodeId b2 = other(*products[0][0], a1), b1 = other(*products[0][1], a2);
      const NodeId b0 = other(*products[1][0], a2), a0 = other(*products[1][1], b2);
      if (b0 == kNoNode || a0 == kNoNode || other(*products[2][0], a0) != b1 ||
          other(*products[2][1], a1) != b0) {
        continue;
      }
      a = {a0, a1, a2};
      b = {b0, b1, b2};
      if (IsVector(a) && IsVector(b)) return true;
    }
  }
  return false;
}

TermId Terms::OfComponents(const Nodes& nodes) {
  Term term{.kind = TermKind::kVector, .vector = true, .uniform = true};
  for (const NodeId node : nodes) {
    term.parts.push_back(OfNumber(node));
    term.uniform = term.uniform && graph_[node].uniform;
  }
  return Add(std::move(term));
}

TermId Terms::MakeVector(const Nodes& nodes) {
  const Node& first = graph_[nodes[0]];
  Term term{.kind = TermKind::kVector, .vector = true};
  if (IsWholeColumn(nodes)) {
    term.kind = TermKind::kLoad;
    term.load = first.load;
    term.uniform = first.uniform;
    return Add(std::move(term));
  }
  if (IsWholeParameter(nodes)) {
    term.kind = TermKind::kParameter;
    term.index = first.index;
    term.uniform = true;
    return Add(std::move(term));
  }
  const bool uniform = first.uniform && graph_[nodes[1]].uniform && graph_[nodes[2]].uniform;
  const bool same_operation = std::all_of(nodes.begin(), nodes.end(), [&](NodeId node) {
    return graph_[node].operation == first.operation;
  });
  if (uniform || !same_operation || first.a == kNoNode) return OfComponents(nodes);
  Nodes left, right;
  switch (first.operation) {
    case Operation::kNegate: {
      for (uint32_t k = 0; k < 3; ++k) left[k] = graph_[nodes[k]].a;
      term.kind = TermKind::kNegative;
      term.parts = {OfVector(left)};
      return Add(std::move(term));
    }
    case Operation::kSubtract:
      if (FindCross(nodes, left, right)) {
        term.kind = TermKind::kCross;
        term.parts = {OfVector(left), OfVector(right)};
        return Add(std::move(term));
      }
      [[fallthrough]];
    case Operation::kAdd:
      Split(nodes, left, right);
      if (!IsVector(left) && !IsVector(right)) return OfComponents(nodes);
      term.kind = first.operation == Operation::kAdd ? TermKind::kSum : TermKind::kDifference;
      term.parts = {OfVector(left), OfVector(right)};
      return Add(std::move(term));
    case Operation::kMultiply: {
      NodeId scalar = kNoNode;
      if (!FindScalar(nodes, scalar, right)) return OfComponents(nodes);
      term.kind = TermKind::kScaled;
      term.parts = {OfNumber(scalar), OfVector(right)};
      return Add(std::move(term));
    }
    case Operation::kSelect: {
      for (const NodeId node : nodes) {
        if (graph_[node].a != first.a) return OfComponents(nodes);
      }
      for (uint32_t k = 0; k < 3; ++k) {
        left[k] = graph_[nodes[k]].b;
        right[k] = graph_[nodes[k]].c;
      }
      term.kind = TermKind::kChoice;
      term.parts = {OfNumber(first.a), OfVector(left), OfVector(right)};
      return Add(std::move(term));
    }
    default:
      return OfComponents(nodes);
  }
}

}  // namespace vesper::text
