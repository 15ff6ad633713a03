// SPDX-License-Identifier: Apache-2.0
#include "graph.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "kernels.hpp"

namespace vesper::text {
namespace {

bool Commutes(Operation operation) {
  switch (operation) {
    case Operation::kAdd:
    case Operation::kMultiply:
    case Operation::kMin:
    case Operation::kMax:
    case Operation::kEqual:
    case Operation::kAnd:
    case Operation::kOr:
      return true;
    default:
      return false;
  }
}

}  // namespace

size_t Graph::Hash::operator()(const Node& node) const {
  uint64_t hash = static_cast<uint64_t>(node.operation);
  const auto mix = [&](uint64_t part) {
    hash = (hash ^ part) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  };
  mix(node.a);
  mix(node.b);
  mix(node.c);
  mix(std::bit_cast<uint64_t>(node.value));
  mix(node.index);
  mix(uint64_t{node.load.participant} << 32 | uint64_t{node.load.property} << 16 |
      node.load.component);
  return hash;
}

bool Graph::Same::operator()(const Node& a, const Node& b) const {
  return a.operation == b.operation && a.a == b.a && a.b == b.b && a.c == b.c &&
         std::bit_cast<uint64_t>(a.value) == std::bit_cast<uint64_t>(b.value) &&
         a.index == b.index && a.load == b.load;
}

NodeId Graph::Intern(Node node) {
  const auto [found, is_new] = known_.try_emplace(node, static_cast<NodeId>(nodes_.size()));
  if (!is_new) return found->second;
  if (nodes_.size() >= kMostNodes) throw TooLarge{};
  node.span = span_;
  nodes_.push_back(node);
  return found->second;
}

NodeId Graph::Constant(double value) {
  return Intern({.operation = Operation::kConstant, .uniform = true, .span = {}, .value = value});
}

NodeId Graph::Parameter(uint32_t index) {
  return Intern({.operation = Operation::kParameter, .uniform = true, .span = {}, .index = index});
}

NodeId Graph::Leaf(Operation operation) {
  return Intern({.operation = operation, .uniform = true, .span = {}});
}

NodeId Graph::LoadOf(const Load& load) {
  return Intern({.operation = Operation::kLoad,
                 .uniform = load.participant == kWorld,
                 .span = {},
                 .load = load});
}

NodeId Graph::Unary(Operation operation, NodeId a) {
  const Node& node = nodes_[a];
  if (node.operation == Operation::kConstant) return Constant(Compute(operation, node.value, 0, 0));
  if (operation == Operation::kNegate) {
    if (node.operation == Operation::kNegate) return node.a;
    if (node.operation == Operation::kSubtract) return Subtract(node.b, node.a);
  }
  return Intern({.operation = operation, .uniform = node.uniform, .span = {}, .a = a});
}

NodeId Graph::Binary(Operation operation, NodeId a, NodeId b) {
  if (IsConstant(a) && IsConstant(b)) {
    return Constant(Compute(operation, nodes_[a].value, nodes_[b].value, 0));
  }
  const auto negated = [&](NodeId id) { return nodes_[id].operation == Operation::kNegate; };
  switch (operation) {
    case Operation::kAdd:
      if (IsConstant(a, 0)) return b;
      if (IsConstant(b, 0)) return a;
      if (a == b) return Multiply(Constant(2), a);
      if (negated(a) && negated(b)) return Negate(Add(nodes_[a].a, nodes_[b].a));
      if (negated(b)) return Subtract(a, nodes_[b].a);
      if (negated(a)) return Subtract(b, nodes_[a].a);
      if (nodes_[a].operation == Operation::kSubtract &&
          nodes_[b].operation == Operation::kSubtract && nodes_[a].a == nodes_[b].b &&
          nodes_[a].b == nodes_[b].a) {
        return Constant(0);
      }
      break;
    case Operation::kSubtract:
      if (IsConstant(b, 0)) return a;
      if (IsConstant(a, 0)) return Negate(b);
      if (a == b) return Constant(0);
      if (negated(b)) return Add(a, nodes_[b].a);
      if (negated(a)) return Negate(Add(nodes_[a].a, b));
      break;
    case Operation::kMultiply:
      // A product with 0 is 0, unless the other factor is not finite. This case needs no result,
      // because such a factor is a fault, which is reported elsewhere.
      if (IsConstant(a, 0) || IsConstant(b, 0)) return Constant(0);
      if (a == b && nodes_[a].operation == Operation::kSqrt) return nodes_[a].a;
      if (IsConstant(a, 1)) return b;
      if (IsConstant(b, 1)) return a;
      if (IsConstant(a, -1)) return Negate(b);
      if (IsConstant(b, -1)) return Negate(a);
      if (negated(a) && negated(b)) return Multiply(nodes_[a].a, nodes_[b].a);
      if (negated(a)) return Negate(Multiply(nodes_[a].a, b));
      if (negated(b)) return Negate(Multiply(a, nodes_[b].a));
      break;
    case Operation::kDivide:
      if (IsConstant(b, 1)) return a;
      if (IsConstant(a, 0)) return Constant(0);
      if (negated(a)) return Negate(Divide(nodes_[a].a, b));
      if (negated(b)) return Negate(Divide(a, nodes_[b].a));
      break;
    case Operation::kAnd:
      if (IsConstant(a, 1) || a == b) return b;
      if (IsConstant(b, 1)) return a;
      if (IsConstant(a, 0) || IsConstant(b, 0)) return Constant(0);
      break;
    case Operation::kOr:
      if (IsConstant(a, 0) || a == b) return b;
      if (IsConstant(b, 0)) return a;
      if (IsConstant(a, 1) || IsConstant(b, 1)) return Constant(1);
      break;
    case Operation::kMin:
    case Operation::kMax:
      if (a == b) return a;
      break;
    default:
      break;
  }
  if (Commutes(operation) && b < a) std::swap(a, b);
  return Intern({.operation = operation,
                 .uniform = nodes_[a].uniform && nodes_[b].uniform,
                 .span = {},
                 .a = a,
                 .b = b});
}

NodeId Graph::Select(NodeId condition, NodeId a, NodeId b) {
  if (a == b) return a;
  if (IsConstant(condition)) return nodes_[condition].value != 0 ? a : b;
  if (nodes_[condition].operation == Operation::kNot) return Select(nodes_[condition].a, b, a);
  // Moves signs out of products. This makes equal and opposite sums recognisable.
  const auto negated = [&](NodeId id) { return nodes_[id].operation == Operation::kNegate; };
  if (negated(a) && (negated(b) || IsConstant(b, 0))) {
    return Negate(Select(condition, nodes_[a].a, negated(b) ? nodes_[b].a : b));
  }
  if (negated(b) && IsConstant(a, 0)) return Negate(Select(condition, a, nodes_[b].a));
  return Intern({.operation = Operation::kSelect,
                 .uniform = nodes_[condition].uniform && nodes_[a].uniform && nodes_[b].uniform,
                 .span = {},
                 .a = condition,
                 .b = a,
                 .c = b});
}

NodeId Graph::WholePower(NodeId a, int n) {
  if (n == 0) return Constant(1);
  if (n < 0) return Divide(Constant(1), WholePower(a, -n));
  if (n == 1) return a;
  const NodeId half = WholePower(a, n / 2);
  const NodeId square = Multiply(half, half);
  return n % 2 == 0 ? square : Multiply(square, a);
}

std::vector<NodeId> Graph::Ordered(NodeId root) const {
  // Ids increase from operands to results, so their order is an order of evaluation.
  std::vector<bool> needed(root + 1);
  needed[root] = true;
  std::vector<NodeId> order;
  for (NodeId id = root + 1; id-- > 0;) {
    if (!needed[id]) continue;
    order.push_back(id);
    for (const NodeId operand : {nodes_[id].a, nodes_[id].b, nodes_[id].c}) {
      if (operand != kNoNode) needed[operand] = true;
    }
  }
  std::reverse(order.begin(), order.end());
  return order;
}

bool Graph::IsContinuous(NodeId root) const {
  for (const NodeId id : Ordered(root)) {
    switch (nodes_[id].operation) {
      case Operation::kTime:
      case Operation::kStep:
      case Operation::kStage:
      case Operation::kFloor:
      case Operation::kTan:
      case Operation::kAtan2:
      case Operation::kSelect:
        return false;
      default:
        break;
    }
  }
  return true;
}

std::vector<Load> Graph::LoadsOf(NodeId root, std::initializer_list<NodeId> behind) const {
  std::vector<bool> needed(root + 1);
  needed[root] = true;
  std::vector<Load> loads;
  for (NodeId id = root + 1; id-- > 0;) {
    if (!needed[id] || std::ranges::find(behind, id) != behind.end()) continue;
    if (nodes_[id].operation == Operation::kLoad) loads.push_back(nodes_[id].load);
    for (const NodeId operand : {nodes_[id].a, nodes_[id].b, nodes_[id].c}) {
      if (operand != kNoNode) needed[operand] = true;
    }
  }
  return loads;
}

NodeId Graph::Substitute(NodeId root, const std::map<NodeId, NodeId>& replacements) {
  std::map<NodeId, NodeId> copies = replacements;
  for (const NodeId id : Ordered(root)) {
    if (copies.contains(id)) continue;
    const Node node = nodes_[id];
    if (node.a == kNoNode) {
      copies[id] = id;
    } else if (node.c != kNoNode) {
      copies[id] = Select(copies[node.a], copies[node.b], copies[node.c]);
    } else if (node.b != kNoNode) {
      copies[id] = Binary(node.operation, copies[node.a], copies[node.b]);
    } else {
      copies[id] = Unary(node.operation, copies[node.a]);
    }
  }
  return copies[root];
}

std::vector<NodeId> Graph::ShareDivisions(const std::vector<NodeId*>& roots) {
  const auto size = static_cast<NodeId>(nodes_.size());
  std::vector<bool> needed(size);
  std::vector<uint32_t> divisions(size);
  for (const NodeId* root : roots) needed[*root] = true;
  for (NodeId id = size; id-- > 0;) {
    if (!needed[id]) continue;
    const Node& node = nodes_[id];
    for (const NodeId operand : {node.a, node.b, node.c}) {
      if (operand != kNoNode) needed[operand] = true;
    }
    if (node.operation == Operation::kDivide && !node.uniform) ++divisions[node.b];
  }
  std::vector<NodeId> copies(size, kNoNode);
  for (NodeId id = 0; id < size; ++id) {
    if (!needed[id]) continue;
    const Node node = nodes_[id];
    At(node.span);
    if (node.a == kNoNode) {
      copies[id] = id;
    } else if (node.operation == Operation::kDivide && !node.uniform &&
               (divisions[node.b] > 1 || nodes_[node.b].uniform)) {
      copies[id] = Multiply(copies[node.a], Divide(Constant(1), copies[node.b]));
    } else if (node.c != kNoNode) {
      copies[id] = Select(copies[node.a], copies[node.b], copies[node.c]);
    } else if (node.b != kNoNode) {
      copies[id] = Binary(node.operation, copies[node.a], copies[node.b]);
    } else {
      copies[id] = Unary(node.operation, copies[node.a]);
    }
  }
  for (NodeId* root : roots) *root = copies[*root];
  return copies;
}

std::map<Load, NodeId> Graph::Gradient(NodeId root, const std::vector<Load>& wanted) {
  std::map<Load, NodeId> gradient;
  Differentiate(root, Constant(1), wanted, gradient, 0);
  return gradient;
}

/// Differentiates backwards from `root`, and adds `adjoint` times its derivatives to the results.
/// The branches of a choice are differentiated separately. Therefore NaN or infinity in the branch
/// that is not taken does not affect the other branch.
void Graph::Differentiate(NodeId root, NodeId adjoint, const std::vector<Load>& wanted,
                          std::map<Load, NodeId>& gradient, int depth) {
  if (depth > 24) throw TooLarge{};
  std::map<NodeId, NodeId> adjoints{{root, adjoint}};
  // Finds the nodes that depend on a wanted load, because other nodes need no derivative.
  const std::vector<NodeId> order = Ordered(root);
  steps_ += order.size();
  if (steps_ > kMostSteps) throw TooLarge{};
  std::vector<bool> depends(root + 1);
  for (const NodeId id : order) {
    const Node& node = nodes_[id];
    if (node.operation == Operation::kLoad) {
      depends[id] = std::find(wanted.begin(), wanted.end(), node.load) != wanted.end();
    }
    for (const NodeId operand : {node.a, node.b, node.c}) {
      if (operand != kNoNode && depends[operand]) depends[id] = true;
    }
  }
  const auto add = [&](NodeId to, NodeId what) {
    if (!depends[to]) return;
    const auto [found, is_new] = adjoints.try_emplace(to, what);
    if (!is_new) found->second = Add(found->second, what);
  };
  const auto add_branches = [&](NodeId condition, NodeId a, NodeId b, NodeId by) {
    std::map<Load, NodeId> first, second;
    Differentiate(a, by, wanted, first, depth + 1);
    Differentiate(b, by, wanted, second, depth + 1);
    for (const Load& load : wanted) {
      const auto in_first = first.find(load), in_second = second.find(load);
      if (in_first == first.end() && in_second == second.end()) continue;
      const NodeId zero = Constant(0);
      const NodeId chosen = Select(condition, in_first == first.end() ? zero : in_first->second,
                                   in_second == second.end() ? zero : in_second->second);
      const auto [found, is_new] = gradient.try_emplace(load, chosen);
      if (!is_new) found->second = Add(found->second, chosen);
    }
  };
  for (auto at = order.rbegin(); at != order.rend(); ++at) {
    const NodeId id = *at;
    const auto found = adjoints.find(id);
    if (found == adjoints.end() || !depends[id]) continue;
    const NodeId by = found->second;
    const Node node = nodes_[id];
    const NodeId a = node.a, b = node.b;
    switch (node.operation) {
      case Operation::kLoad: {
        const auto [entry, is_new] = gradient.try_emplace(node.load, by);
        if (!is_new) entry->second = Add(entry->second, by);
        break;
      }
      case Operation::kAdd:
        add(a, by);
        add(b, by);
        break;
      case Operation::kSubtract:
        add(a, by);
        add(b, Negate(by));
        break;
      case Operation::kMultiply:
        if (a == b) {
          add(a, Multiply(Multiply(Constant(2), by), a));
        } else {
          add(a, Multiply(by, b));
          add(b, Multiply(by, a));
        }
        break;
      case Operation::kDivide:
        add(a, Divide(by, b));
        if (depends[b]) add(b, Negate(Divide(Multiply(by, id), b)));
        break;
      case Operation::kNegate:
        add(a, Negate(by));
        break;
      case Operation::kSqrt:  // the derivative at 0 is set to 0, because a vector of length 0 has
                              // no direction
        add(a, Select(Binary(Operation::kEqual, a, Constant(0)), Constant(0),
                      Divide(Multiply(Constant(0.5), by), id)));
        break;
      case Operation::kAbs:
        add(a, Select(Binary(Operation::kLess, a, Constant(0)), Negate(by), by));
        break;
      case Operation::kMin:
        add_branches(Binary(Operation::kLess, b, a), b, a, by);
        break;
      case Operation::kMax:
        add_branches(Binary(Operation::kLess, a, b), b, a, by);
        break;
      case Operation::kSelect:
        add_branches(a, node.b, node.c, by);
        break;
      case Operation::kExp:
        add(a, Multiply(by, id));
        break;
      case Operation::kLn:
        add(a, Divide(by, a));
        break;
      case Operation::kSin:
        add(a, Multiply(by, Unary(Operation::kCos, a)));
        break;
      case Operation::kCos:
        add(a, Negate(Multiply(by, Unary(Operation::kSin, a))));
        break;
      case Operation::kTan:
        add(a, Multiply(by, Add(Constant(1), Multiply(id, id))));
        break;
      case Operation::kAsin:
        add(a, Divide(by, Sqrt(Subtract(Constant(1), Multiply(a, a)))));
        break;
      case Operation::kAcos:
        add(a, Negate(Divide(by, Sqrt(Subtract(Constant(1), Multiply(a, a))))));
        break;
      case Operation::kAtan:
        add(a, Divide(by, Add(Constant(1), Multiply(a, a))));
        break;
      case Operation::kAtan2: {
        const NodeId square = Add(Multiply(a, a), Multiply(b, b));
        add(a, Divide(Multiply(by, b), square));
        add(b, Negate(Divide(Multiply(by, a), square)));
        break;
      }
      case Operation::kTanh:
        add(a, Multiply(by, Subtract(Constant(1), Multiply(id, id))));
        break;
      case Operation::kPower:
        if (depends[a]) {
          add(a, Multiply(by, Multiply(b, Binary(Operation::kPower, a, Subtract(b, Constant(1))))));
        }
        if (depends[b]) add(b, Multiply(by, Multiply(id, Unary(Operation::kLn, a))));
        break;
      default:  // piecewise constant: the derivative is 0
        break;
    }
  }
}

double Compute(Operation operation, double a, double b, double c) {
  return ComputeIn<double>(operation, a, b, c);
}

}  // namespace vesper::text
