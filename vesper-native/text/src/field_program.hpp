// SPDX-License-Identifier: Apache-2.0
// A function of position that a law text provides.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "graph.hpp"

namespace vesper::text {

/// Index of the parameter that stands for the first component of the place in formulas of fields.
inline constexpr uint32_t kPlaceParameter = 1u << 20;

/// The formulas of a field as a list of operations. Any number of threads may evaluate it.
class FieldProgram {
 public:
  static constexpr size_t kMostNodes = 2000;

  /// Values that are the same at all places.
  struct Uniforms {
    std::span<const double> parameters;
    double time;  // at the start of the step [s]
  };
  /// The part of a formula that is the cause of a value that is not finite, or the whole formula.
  struct Cause {
    Span span;
    const char* what;  // for example "divides by zero"
  };

  FieldProgram() = default;
  /// Takes the formulas of the components from a graph.
  FieldProgram(const Graph& graph, std::span<const NodeId> values);
  /// Returns a program that computes each component and its derivatives by x, y and z. Returns an
  /// empty program if the derivatives are too large. `span` is the formula in the text.
  static FieldProgram WithSlopes(const Graph& graph, std::span<const NodeId> values, Span span);

  size_t size() const { return steps_.size(); }
  bool DependsOnTime() const;
  /// Computes the values (count x components) at places (count x 3) [m].
  void Evaluate(const Uniforms& uniforms, uint64_t count, const double* at,
                double* out) const noexcept;
  /// Returns true if all values at a place (3) [m] are finite.
  bool IsFinite(const Uniforms& uniforms, const double* at) const noexcept;
  /// Returns why the value at a place (3) [m] is not finite, or too large to be used.
  Cause Explain(const Uniforms& uniforms, const double* at) const;

 private:
  struct Step {
    Operation operation;
    uint32_t a = 0;  // indices of earlier steps
    uint32_t b = 0;
    uint32_t c = 0;
    double value = 0;
    uint32_t index = 0;
    bool leaf = true;  // no operands
    Span span{};
  };
  using Values = std::array<double, kMostNodes>;

  void ComputeAt(const Uniforms& uniforms, const double* at, Values& values) const noexcept;

  std::vector<Step> steps_;
  std::vector<uint32_t> results_;  // steps of the components
};

}  // namespace vesper::text
