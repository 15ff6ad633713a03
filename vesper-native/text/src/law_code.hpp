// SPDX-License-Identifier: Apache-2.0
// A checked law: its formulas as a graph, and the properties, parameters and rows that it uses.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dimension.hpp"
#include "graph.hpp"
#include "prototype.hpp"
#include "syntax.hpp"
#include "vesper/law.h"

namespace vesper::text {

/// A property that a law uses, or memory of its own for each row of a kind.
struct PropertyCode {
  std::string name;
  std::string kind;
  uint32_t components = 1;
  Dimension dimension{};
  bool is_reference = false;  // u32 rows of another kind
  bool own = false;           // SCRATCH
  bool optional = false;
  bool accumulator = false;
  bool read = false;      // a formula depends on it
  bool stored = false;    // `=`, every row in every call
  bool modified = false;  // written otherwise
  bool added = false;     // `+=` into an accumulator
  Span set_at{};          // first statement that changes it

  vesper_access Access() const;
};

struct ParameterCode {
  std::string name;
  std::string doc;
  Dimension dimension{};
  double value = 0;
  double minimum = 0;
  double maximum = 0;
};

/// A result that is stored or added for each row of a block.
struct Output {
  Load to;
  bool add;
  NodeId value;
  Span span;
};

/// One pass over rows, pairs of rows, or rows with those that they refer to.
struct PassCode {
  BlockKind kind;
  Span span;
  std::string rows;  // kind of the rows
  /// For each participant from kFirst on, the reference of the row: property and component.
  std::vector<Load> references;
  std::vector<std::string> participant_names;
  NodeId within = kNoNode;  // uniform
  uint16_t position = 0;    // property of the positions that `within` compares
  std::optional<uint32_t> stage;
  std::vector<Output> outputs;
  NodeId energy = kNoNode;
};

struct LawCode {
  std::string name;
  std::string doc;
  std::string version;
  vesper_phase phase = VESPER_PHASE_FORCE;
  uint32_t stages = 0;
  uint32_t first_stage = 0;
  std::vector<double> force_weights;
  uint32_t claims = 0;
  bool has_energy = false;
  std::vector<ParameterCode> parameters;
  std::vector<PropertyCode> properties;
  /// Places in `properties` in the order of the law's table: own memory comes last, so that a value
  /// that is not finite is blamed on a property of the world first.
  std::vector<uint32_t> table_order;
  std::vector<PassCode> passes;
  Graph graph;
};

/// Checks a law of a text against the properties of a world. Adds what is wrong to `problems`; the
/// result is meaningful only if there are none.
LawCode Check(std::string_view text, const LawTree& law, const Prototype& prototype,
              Problems& problems);

/// Derives VESPER_CLAIM_… of a law from its formulas. `uses_axes`: a formula names a direction of
/// the world's axes.
uint32_t DeriveClaims(LawCode& law, bool uses_axes);

}  // namespace vesper::text
