// SPDX-License-Identifier: Apache-2.0
#include "field_program.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace vesper::text {
namespace {

/// Returns the load that stands for a component of the place while a formula is differentiated.
Load LoadOfPlace(uint16_t component) { return {kOwnRow, 0, component}; }

/// Copies a formula of a field to another graph, with loads in place of the place's components.
/// `copies` contains the nodes that were copied before.
NodeId CopyWithLoads(const Graph& from, NodeId root, Graph& to, std::map<NodeId, NodeId>& copies) {
  for (const NodeId id : from.Ordered(root)) {
    if (copies.contains(id)) continue;
    const Node& node = from[id];
    to.At(node.span);
    NodeId copy;
    if (node.operation == Operation::kConstant) {
      copy = to.Constant(node.value);
    } else if (node.operation == Operation::kParameter) {
      copy = node.index < kPlaceParameter
                 ? to.Parameter(node.index)
                 : to.LoadOf(LoadOfPlace(static_cast<uint16_t>(node.index - kPlaceParameter)));
    } else if (node.a == kNoNode) {
      copy = to.Leaf(node.operation);
    } else if (node.c != kNoNode) {
      copy = to.Select(copies.at(node.a), copies.at(node.b), copies.at(node.c));
    } else if (node.b != kNoNode) {
      copy = to.Binary(node.operation, copies.at(node.a), copies.at(node.b));
    } else {
      copy = to.Unary(node.operation, copies.at(node.a));
    }
    copies.emplace(id, copy);
  }
  return copies.at(root);
}

}  // namespace

FieldProgram FieldProgram::WithSlopes(const Graph& graph, std::span<const NodeId> values,
                                      Span span) {
  Graph copy;
  std::map<NodeId, NodeId> copies;
  std::vector<NodeId> results;
  const std::vector<Load> place{LoadOfPlace(0), LoadOfPlace(1), LoadOfPlace(2)};
  try {
    for (const NodeId value : values) {
      const NodeId root = CopyWithLoads(graph, value, copy, copies);
      copy.At(span);
      const std::map<Load, NodeId> gradient = copy.Gradient(root, place);
      results.push_back(root);
      for (const Load& load : place) {
        const auto found = gradient.find(load);
        results.push_back(found == gradient.end() ? copy.Constant(0) : found->second);
      }
    }
  } catch (const TooLarge&) {
    return {};
  }
  FieldProgram program(copy, results);
  return program.size() > kMostNodes ? FieldProgram() : program;
}

FieldProgram::FieldProgram(const Graph& graph, std::span<const NodeId> values) {
  std::set<NodeId> needed;
  for (const NodeId value : values) {
    for (const NodeId id : graph.Ordered(value)) needed.insert(id);
  }
  std::map<NodeId, uint32_t> steps;
  const auto step_of = [&](NodeId id) { return id == kNoNode ? 0 : steps.at(id); };
  for (const NodeId id : needed) {
    const Node& node = graph[id];
    const bool is_place = node.operation == Operation::kLoad;
    steps.emplace(id, static_cast<uint32_t>(steps_.size()));
    steps_.push_back({.operation = is_place ? Operation::kParameter : node.operation,
                      .a = step_of(node.a),
                      .b = step_of(node.b),
                      .c = step_of(node.c),
                      .value = node.value,
                      .index = is_place ? kPlaceParameter + node.load.component : node.index,
                      .leaf = node.a == kNoNode,
                      .span = node.span});
  }
  for (const NodeId value : values) results_.push_back(steps.at(value));
}

bool FieldProgram::DependsOnTime() const {
  return std::ranges::any_of(steps_,
                             [](const Step& step) { return step.operation == Operation::kTime; });
}

void FieldProgram::ComputeAt(const Uniforms& uniforms, const double* at,
                             Values& values) const noexcept {
  for (size_t k = 0; k < steps_.size(); ++k) {
    const Step& step = steps_[k];
    if (step.operation == Operation::kConstant) {
      values[k] = step.value;
    } else if (step.operation == Operation::kParameter) {
      values[k] = step.index >= kPlaceParameter ? at[step.index - kPlaceParameter]
                                                : uniforms.parameters[step.index];
    } else if (step.operation == Operation::kTime) {
      values[k] = uniforms.time;
    } else {
      values[k] = Compute(step.operation, values[step.a], values[step.b], values[step.c]);
    }
  }
}

void FieldProgram::Evaluate(const Uniforms& uniforms, uint64_t count, const double* at,
                            double* out) const noexcept {
  Values values;
  for (uint64_t i = 0; i < count; ++i) {
    ComputeAt(uniforms, at + 3 * i, values);
    for (size_t k = 0; k < results_.size(); ++k) out[i * results_.size() + k] = values[results_[k]];
  }
}

bool FieldProgram::IsFinite(const Uniforms& uniforms, const double* at) const noexcept {
  Values values;
  ComputeAt(uniforms, at, values);
  return std::ranges::all_of(results_, [&](uint32_t step) { return std::isfinite(values[step]); });
}

FieldProgram::Cause FieldProgram::Explain(const Uniforms& uniforms, const double* at) const {
  Values values;
  ComputeAt(uniforms, at, values);
  const auto smaller = [&](uint32_t a, uint32_t b) {
    return std::abs(values[a]) < std::abs(values[b]);
  };
  const auto lost =
      std::ranges::find_if(results_, [&](uint32_t step) { return !std::isfinite(values[step]); });
  if (lost == results_.end()) {
    return {steps_[*std::ranges::max_element(results_, smaller)].span, "is too large"};
  }
  uint32_t made = *lost;
  while (!steps_[made].leaf) {
    const Step& step = steps_[made];
    const bool choice = step.operation == Operation::kSelect;
    uint32_t cause = made;
    for (const uint32_t operand : {step.a, step.b, step.c}) {
      if (std::isfinite(values[operand])) continue;
      if (choice && operand != (values[step.a] != 0 ? step.b : step.c)) continue;
      cause = operand;
      break;
    }
    if (cause == made) break;
    made = cause;
  }
  const Step& step = steps_[made];
  if (step.operation == Operation::kDivide && values[step.b] == 0) {
    return {step.span, "divides by zero"};
  }
  return {step.span, std::isnan(values[made]) ? "has no value" : "is too large"};
}

}  // namespace vesper::text
