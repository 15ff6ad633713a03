// SPDX-License-Identifier: Apache-2.0
// A checked law: its formulas as a graph, and the properties, parameters and rows that it uses.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dimension.hpp"
#include "field_program.hpp"
#include "graph.hpp"
#include "prototype.hpp"
#include "syntax.hpp"
#include "vesper/law.h"

namespace vesper::text {

/// A property that a law uses, or memory of its own (SCRATCH) for each row of a kind.
struct PropertyCode {
  std::string name;
  std::string kind;
  uint32_t components = 1;
  Dimension dimension{};
  bool is_reference = false;  // its values are u32 rows of another kind
  bool own = false;           // memory of the law: SCRATCH
  bool is_field = false;      // a function of position, at the positions of the rows of `kind`
  uint16_t positions = 0;     // of a field: property of these positions
  std::string field_kind;     // of a field: kind that declares it
  /// Of a field: 1 + the component whose derivatives by x, y and z these are; 0: the value itself.
  uint16_t slope_of = 0;
  uint32_t field_components = 1;  // of a field: components of its value
  /// Of a field: the first property of the list with the same field. The law's table has one entry
  /// for all of them.
  uint16_t first_of_field = 0;
  bool sloped = false;  // at `first_of_field`: the law reads slopes, too
  /// Type of a real property with another precision than the reals of the world; 0 for all others.
  vesper_scalar_type other_type = 0;
  /// Type of a real property that has the same precision in worlds of both precisions, for
  /// generated code; 0 for all others.
  vesper_scalar_type fixed_type = 0;
  bool optional = false;
  bool accumulator = false;
  bool read = false;      // a formula depends on it
  bool stored = false;    // assigned by `=` in every row and every call
  bool modified = false;  // written in another way
  bool added = false;     // an accumulator to which `+=` adds
  Span set_at{};          // first statement that changes it

  vesper_access Access() const;
};

/// A function of position that a law provides.
struct FieldCode {
  std::string name;
  std::string doc;
  uint32_t components = 1;
  Dimension dimension{};
  std::array<NodeId, 3> values{kNoNode, kNoNode, kNoNode};
  FieldProgram program;
  FieldProgram slopes;  // with the slopes of each component; empty: the formulas are too large
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

/// A value that a text has given a name, by `let` or in a heading.
struct NamedValue {
  std::string name;
  uint32_t components = 1;
  std::array<NodeId, 4> node{kNoNode, kNoNode, kNoNode, kNoNode};  // kNoNode: no result needs it
};

/// One pass of a law over rows, pairs of rows, or rows together with the rows that they refer to.
struct PassCode {
  BlockKind kind;
  Span span;
  std::string rows;  // kind of the rows
  /// For each participant from kFirst on, the reference through which the row refers to it:
  /// property and component.
  std::vector<Load> references;
  std::vector<std::string> participant_names;
  NodeId within = kNoNode;  // the distance of `within`; the same for all rows
  uint16_t position = 0;    // property of the positions that `within` compares
  std::optional<uint32_t> stage;
  std::vector<Output> outputs;
  NodeId energy = kNoNode;
  bool checks_limits = false;     // its results are NaN for values beyond their limits
  bool conserves_energy = false;  // all its effects are forces that follow from a continuous energy
  std::vector<NamedValue> names;  // names for readers of generated code
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
  /// Indices into `properties` in the order of the law's table. Memory of the law comes last, so
  /// that a message about a value that is not finite names a property of the world if possible.
  std::vector<uint32_t> table_order;
  std::vector<PassCode> passes;
  std::vector<FieldCode> fields;
  Graph graph;
};

/// Checks a law of a text against the properties of a world. Adds problems to `problems`. The
/// result is valid only if there are no problems.
LawCode Check(std::string_view text, const LawTree& law, const Prototype& prototype,
              Problems& problems);

/// Derives VESPER_CLAIM_… of a law from its formulas. `uses_axes`: true if a formula contains a
/// direction of the world's axes, so that the law cannot claim rotation.
uint32_t DeriveClaims(LawCode& law, bool uses_axes);

}  // namespace vesper::text
