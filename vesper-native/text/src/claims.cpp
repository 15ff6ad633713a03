// SPDX-License-Identifier: Apache-2.0
// The claims of a law (such as conserved momentum), derived from its formulas.
#include <map>
#include <optional>
#include <vector>

#include "law_code.hpp"

namespace vesper::text {
namespace {

bool IsPosition(const PropertyCode& use) { return use.name == "position" && use.components == 3; }

/// The change of each node's value if the origin is shifted. It is a factor of the shift: 1 for a
/// position, and 0 for a value that does not change, such as a difference of positions. The change
/// is empty if the value changes in another way.
class Origins {
 public:
  explicit Origins(const LawCode& law) : law_(law) {
    origins_.reserve(law.graph.size());
    for (NodeId id = 0; id < law.graph.size(); ++id) origins_.push_back(Compute(id));
  }

  const std::optional<double>& Of(NodeId id) const { return origins_[id]; }

 private:
  /// Returns the change of one node. The operands of a node have smaller ids, so their changes are
  /// already known.
  std::optional<double> Compute(NodeId id) const {
    const Node& node = law_.graph[id];
    if (node.operation == Operation::kLoad) {
      if (law_.properties[node.load.property].is_field) return std::nullopt;
      return IsPosition(law_.properties[node.load.property]) ? 1 : 0;
    }
    if (node.a == kNoNode) return 0;
    const std::optional<double> a = Of(node.a);
    const std::optional<double> b = node.b == kNoNode ? 0 : Of(node.b);
    const std::optional<double> c = node.c == kNoNode ? 0 : Of(node.c);
    if (!a || !b || !c) return std::nullopt;
    if (*a == 0 && *b == 0 && *c == 0) return 0;
    switch (node.operation) {
      case Operation::kAdd:
        return *a + *b;
      case Operation::kSubtract:
        return *a - *b;
      case Operation::kNegate:
        return -*a;
      case Operation::kMultiply:
        if (law_.graph.IsConstant(node.a)) return law_.graph[node.a].value * *b;
        if (law_.graph.IsConstant(node.b)) return law_.graph[node.b].value * *a;
        return std::nullopt;
      case Operation::kDivide:
        if (law_.graph.IsConstant(node.b)) return *a / law_.graph[node.b].value;
        return std::nullopt;
      case Operation::kSelect:
        if (*a == 0 && *b == *c) return *b;
        return std::nullopt;
      default:
        return std::nullopt;
    }
  }

  const LawCode& law_;
  std::vector<std::optional<double>> origins_;
};

/// Writes nodes as products of a factor and `by`. The factor is kNoNode if this is not possible.
class Factors {
 public:
  Factors(Graph& graph, NodeId by) : graph_(graph), by_(by) {}

  NodeId Of(NodeId id, int depth = 0) {
    if (id == by_) return graph_.Constant(1);
    if (graph_.IsConstant(id, 0)) return id;
    if (depth > kMaxDepth) return kNoNode;
    const auto known = known_.find(id);
    if (known != known_.end()) return known->second;
    return known_[id] = Find(id, depth);
  }

 private:
  static constexpr int kMaxDepth = 100;

  NodeId Find(NodeId id, int depth) {
    const Node node = graph_[id];
    const auto inner = [&](NodeId operand) { return Of(operand, depth + 1); };
    switch (node.operation) {
      case Operation::kSubtract: {
        const Node reversed = graph_[by_];
        if (reversed.operation == Operation::kSubtract && node.a == reversed.b &&
            node.b == reversed.a) {
          return graph_.Constant(-1);
        }
        const NodeId a = inner(node.a), b = inner(node.b);
        return a == kNoNode || b == kNoNode ? kNoNode : graph_.Subtract(a, b);
      }
      case Operation::kAdd: {
        const NodeId a = inner(node.a), b = inner(node.b);
        return a == kNoNode || b == kNoNode ? kNoNode : graph_.Add(a, b);
      }
      case Operation::kNegate: {
        const NodeId a = inner(node.a);
        return a == kNoNode ? kNoNode : graph_.Negate(a);
      }
      case Operation::kMultiply: {
        const NodeId a = inner(node.a);
        if (a != kNoNode) return graph_.Multiply(a, node.b);
        const NodeId b = inner(node.b);
        return b == kNoNode ? kNoNode : graph_.Multiply(b, node.a);
      }
      case Operation::kDivide: {
        const NodeId a = inner(node.a);
        return a == kNoNode ? kNoNode : graph_.Divide(a, node.b);
      }
      case Operation::kSelect: {
        const NodeId b = inner(node.b), c = inner(node.c);
        return b == kNoNode || c == kNoNode ? kNoNode : graph_.Select(node.a, b, c);
      }
      default:
        return kNoNode;
    }
  }

  Graph& graph_;
  NodeId by_;
  std::map<NodeId, NodeId> known_;
};

/// Returns the forces of a pass, by participant.
std::map<uint16_t, std::vector<NodeId>> ForcesOf(LawCode& law, const PassCode& pass) {
  std::map<uint16_t, std::vector<NodeId>> forces;
  for (const Output& output : pass.outputs) {
    const PropertyCode& use = law.properties[output.to.property];
    if (use.name != "externalForce" || use.kind != "body") continue;
    auto [entry, is_new] = forces.try_emplace(output.to.participant);
    if (is_new) entry->second.assign(3, law.graph.Constant(0));
    entry->second[output.to.component] = output.value;
  }
  return forces;
}

bool SumsToZero(LawCode& law, const std::map<uint16_t, std::vector<NodeId>>& forces) {
  for (size_t i = 0; i < 3; ++i) {
    NodeId sum = law.graph.Constant(0);
    for (const auto& [participant, force] : forces) sum = law.graph.Add(sum, force[i]);
    if (!law.graph.IsConstant(sum, 0)) return false;
  }
  return true;
}

/// Returns true if equal and opposite forces act along the line between the two participants.
bool IsCentral(LawCode& law, const PassCode& pass, const std::vector<NodeId>& force) {
  Graph& graph = law.graph;
  if (pass.kind == BlockKind::kRows || pass.participant_names.size() != 2) return false;
  NodeId common = kNoNode;
  for (uint16_t i = 0; i < 3; ++i) {
    const NodeId separation = graph.Subtract(graph.LoadOf({kFirst + 1, pass.position, i}),
                                             graph.LoadOf({kFirst, pass.position, i}));
    const NodeId factor = Factors(graph, separation).Of(force[i]);
    if (factor == kNoNode || (common != kNoNode && factor != common)) return false;
    common = factor;
  }
  return true;
}

/// Returns true if all forces follow from continuous energies, whose other properties the law does
/// not change.
bool ConservesEnergy(const LawCode& law) {
  std::vector<bool> changes(law.properties.size()), matters(law.properties.size());
  for (const PassCode& pass : law.passes) {
    if (pass.energy != kNoNode) {
      if (!pass.conserves_energy) return false;
      for (const Load& load : law.graph.LoadsOf(pass.energy)) matters[load.property] = true;
      continue;
    }
    for (const Output& output : pass.outputs) {
      if (law.properties[output.to.property].accumulator) return false;
      changes[output.to.property] = true;
    }
  }
  for (size_t i = 0; i < changes.size(); ++i) {
    if (changes[i] && matters[i]) return false;
  }
  return law.has_energy;
}

}  // namespace

uint32_t DeriveClaims(LawCode& law, bool uses_axes) {
  uint32_t claims = VESPER_CLAIM_TRANSLATION | (uses_axes ? 0 : VESPER_CLAIM_ROTATION);
  const Origins origins(law);
  for (const PassCode& pass : law.passes) {
    for (const Output& output : pass.outputs) {
      const PropertyCode& use = law.properties[output.to.property];
      const double expected = IsPosition(use) && !output.add ? 1 : 0;
      if (origins.Of(output.value) != expected) claims &= ~VESPER_CLAIM_TRANSLATION;
    }
  }
  if (law.phase != VESPER_PHASE_FORCE) return claims;
  bool momentum = true, angular_momentum = true;
  for (const PassCode& pass : law.passes) {
    for (const Output& output : pass.outputs) {
      const PropertyCode& use = law.properties[output.to.property];
      if (output.add && use.accumulator && use.name != "externalForce") angular_momentum = false;
    }
    const auto forces = ForcesOf(law, pass);
    if (forces.empty()) continue;
    const bool balanced = SumsToZero(law, forces);
    momentum = momentum && balanced;
    const bool central = balanced && forces.size() == 2 && forces.contains(kFirst) &&
                         IsCentral(law, pass, forces.at(kFirst));
    angular_momentum = angular_momentum && central;
  }
  if (momentum) claims |= VESPER_CLAIM_MOMENTUM;
  if (ConservesEnergy(law)) claims |= VESPER_CLAIM_ENERGY;
  if (angular_momentum) claims |= VESPER_CLAIM_ANGULAR_MOMENTUM;
  return claims;
}

}  // namespace vesper::text
