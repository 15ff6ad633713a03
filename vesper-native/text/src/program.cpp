// SPDX-License-Identifier: Apache-2.0
#include "program.hpp"

#include <algorithm>

namespace vesper::text {
namespace {

/// The occasions on which a value changes: never during a call of the law, with each first row of a
/// pair, or with each row.
enum class Level : uint8_t { kConstant, kOfFirst, kEach };

class Compiler {
 public:
  Compiler(const LawCode& law, const PassCode& pass)
      : graph_(law.graph),
        all_pairs_(pass.kind == BlockKind::kPairs && pass.within == kNoNode),
        levels_(graph_.size(), Level::kConstant),
        place_(graph_.size(), kNothing),
        last_use_(graph_.size(), 0),
        needed_(graph_.size()),
        pass_(pass) {}

  Program Run(bool energy) {
    std::vector<NodeId> roots;
    if (energy) {
      roots.push_back(pass_.energy);
    } else {
      for (const Output& output : pass_.outputs) roots.push_back(output.value);
    }
    if (pass_.within != kNoNode) roots.push_back(pass_.within);
    Need(roots);
    PlaceUniforms();
    if (pass_.within != kNoNode) {
      program_.within = static_cast<uint16_t>(place_[pass_.within] - kUniform);
    }
    PlaceLoads();
    for (NodeId id = 0; id < graph_.size(); ++id) {
      if (needed_[id] && levels_[id] == Level::kEach && graph_[id].operation != Operation::kLoad) {
        Emit(id);
      }
    }
    if (energy) {
      program_.energy = ResultRegister(pass_.energy);
    } else {
      for (const Output& output : pass_.outputs) AddResult(output);
    }
    for (LoadGroup& group : program_.loads) {
      for (const ResultGroup& result : program_.results) {
        group.written = group.written || result.property == group.property;
      }
    }
    return std::move(program_);
  }

 private:
  void Need(const std::vector<NodeId>& roots) {
    for (const NodeId root : roots) {
      needed_[root] = true;
      last_use_[root] = UINT32_MAX;
    }
    for (NodeId id = static_cast<NodeId>(graph_.size()); id-- > 0;) {
      if (!needed_[id]) continue;
      for (const NodeId operand : {graph_[id].a, graph_[id].b, graph_[id].c}) {
        if (operand == kNoNode) continue;
        needed_[operand] = true;
        last_use_[operand] = std::max(last_use_[operand], id);
      }
    }
    for (NodeId id = 0; id < graph_.size(); ++id) {
      const Node& node = graph_[id];
      if (node.operation == Operation::kLoad && node.load.participant != kWorld) {
        levels_[id] =
            all_pairs_ && node.load.participant == kFirst ? Level::kOfFirst : Level::kEach;
      }
      for (const NodeId operand : {node.a, node.b, node.c}) {
        if (operand != kNoNode) levels_[id] = std::max(levels_[id], levels_[operand]);
      }
    }
  }

  void PlaceUniforms() {
    for (const Level level : {Level::kConstant, Level::kOfFirst}) {
      for (NodeId id = 0; id < graph_.size(); ++id) {
        if (!needed_[id] || levels_[id] != level) continue;
        auto& list = level == Level::kConstant ? program_.constants : program_.of_first;
        place_[id] = static_cast<uint16_t>(kUniform + program_.uniforms());
        list.push_back(id);
        if (graph_[id].operation == Operation::kLoad && level == Level::kOfFirst) {
          GroupOf(program_.loads_of_first, graph_[id].load).to[graph_[id].load.component] =
              static_cast<uint16_t>(place_[id] - kUniform);
        }
      }
    }
  }

  static LoadGroup& GroupOf(std::vector<LoadGroup>& groups, const Load& load) {
    for (LoadGroup& group : groups) {
      if (group.participant == load.participant && group.property == load.property) return group;
    }
    groups.emplace_back();
    groups.back().participant = load.participant;
    groups.back().property = load.property;
    return groups.back();
  }

  /// Assigns registers to loads. They are never overwritten, because they may be the columns of the
  /// world themselves.
  void PlaceLoads() {
    for (NodeId id = 0; id < graph_.size(); ++id) {
      const Node& node = graph_[id];
      if (!needed_[id] || levels_[id] != Level::kEach || node.operation != Operation::kLoad)
        continue;
      place_[id] = program_.registers++;
      GroupOf(program_.loads, node.load).to[node.load.component] = place_[id];
    }
  }

  void Emit(NodeId id) {
    const Node& node = graph_[id];
    Instruction step{node.operation, 0, kNothing, kNothing, kNothing};
    step.a = place_[node.a];
    if (node.b != kNoNode) step.b = place_[node.b];
    if (node.c != kNoNode) step.c = place_[node.c];
    for (const NodeId operand : {node.a, node.b, node.c}) {
      if (operand == kNoNode || last_use_[operand] != id || levels_[operand] != Level::kEach)
        continue;
      if (graph_[operand].operation == Operation::kLoad) continue;
      if (std::find(free_.begin(), free_.end(), place_[operand]) == free_.end()) {
        free_.push_back(place_[operand]);
      }
    }
    if (free_.empty()) {
      step.to = program_.registers++;
    } else {
      step.to = free_.back();
      free_.pop_back();
    }
    place_[id] = step.to;
    program_.code.push_back(step);
  }

  /// Returns the register of a result. In passes over all pairs, parts of results are set to zero.
  /// Therefore a result needs a separate register in these passes.
  uint16_t ResultRegister(NodeId id) {
    const uint16_t found = RegisterOf(id);
    const bool own = levels_[id] == Level::kEach && graph_[id].operation != Operation::kLoad;
    if (!all_pairs_ || own) return found;
    const uint16_t copy = program_.registers++;
    program_.code.push_back({Operation::kMin, copy, found, found, kNothing});
    return copy;
  }

  uint16_t RegisterOf(NodeId id) {
    if (levels_[id] == Level::kEach) return place_[id];
    const auto from = static_cast<uint16_t>(place_[id] - kUniform);
    for (const Fill& fill : program_.fills) {
      if (fill.from == from) return fill.to;
    }
    program_.fills.push_back({program_.registers++, from});
    return program_.fills.back().to;
  }

  void AddResult(const Output& output) {
    const uint16_t from = ResultRegister(output.value);
    for (ResultGroup& group : program_.results) {
      if (group.participant == output.to.participant && group.property == output.to.property &&
          group.add == output.add) {
        group.from[output.to.component] = from;
        return;
      }
    }
    program_.results.push_back({output.to.participant, output.to.property, output.add});
    program_.results.back().from[output.to.component] = from;
  }

  const Graph& graph_;
  const bool all_pairs_;
  Program program_;
  std::vector<Level> levels_;
  std::vector<uint16_t> place_;  // register of each node, or kUniform + index of a uniform value
  std::vector<NodeId> last_use_;
  std::vector<bool> needed_;
  std::vector<uint16_t> free_;
  const PassCode& pass_;
};

}  // namespace

Program Compile(const LawCode& law, const PassCode& pass, bool energy) {
  return Compiler(law, pass).Run(energy);
}

}  // namespace vesper::text
