// SPDX-License-Identifier: Apache-2.0
// Checks of names, units and kinds of values in one law.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "law_code.hpp"

namespace vesper::text {

/// The value of an expression: 1, 3 or 4 numbers with a unit, or a condition.
struct Value {
  Dimension dimension{};
  uint32_t components = 1;
  bool condition = false;
  bool any_unit = false;  // true for the literal 0, which fits every unit
  std::array<NodeId, 4> node{kNoNode, kNoNode, kNoNode, kNoNode};
  Span span{};

  bool IsVector() const { return components == 3; }
  bool IsRotation() const { return components == 4; }
};

/// The results of a block's statements so far. Statements inside `if` work on a copy.
struct Effects {
  std::map<Load, std::pair<NodeId, Span>> stored;
  std::map<Load, std::pair<NodeId, Span>> added;
  NodeId energy = kNoNode;
  Span energy_span{};
};

class Checker {
 public:
  Checker(std::string_view text, const LawTree& tree, const Prototype& prototype,
          Problems& problems);

  LawCode Run();

 private:
  /// A property of the law's own. Its limits are infinite unless the text sets them.
  struct Owned {
    const Ownership* tree;
    uint32_t kind;
    Dimension dimension;
    double minimum = -std::numeric_limits<double>::infinity();
    double maximum = std::numeric_limits<double>::infinity();
  };

  // --- declarations (checker.cpp)
  void Declare();
  void DeclareParameter(const ParameterTree& tree);
  void DeclareOwned(const Ownership& owned);
  void ReadLimits(Owned& owned);
  /// Adds passes at the end of the law that fail for values of its own properties beyond their
  /// limits.
  void CheckLimits();
  /// Checks a function of position that the law provides.
  void DeclareField(const FieldTree& tree);
  void RequireOfPlace(NodeId value, Span span);
  double ConstantOf(const Value& value) const;
  Value ConstantExpression(const Expression& tree, const char* what);
  void DerivePhase();
  void RequireOnlyOwnChanges();
  void FinishProperties();
  uint32_t KindOf(const Name& name, bool plural) const;
  std::string KindSuggestion(const Name& name) const;

  // --- blocks (check_blocks.cpp)
  void CheckBlock(const Block& block);
  void OpenJoined(const Block& block);
  void OpenPairs(const Block& block);
  void OpenSeparation(const Block& block);
  void CheckStatements(const std::vector<Statement>& statements, Effects& effects);
  void CheckStatement(const Statement& statement, Effects& effects);
  void CheckIf(const Statement& statement, Effects& effects);
  void CheckLet(const Statement& statement);
  /// Notes the name of a value of the block for generated code.
  void NoteName(const std::string& name, const Value& value);
  void Assign(const Statement& statement, Effects& effects);
  void AssignEnergy(const Statement& statement, Effects& effects);
  void AssignPull(const Statement& statement, Effects& effects);
  void Push(uint16_t participant, const std::array<NodeId, 3>& force, Span span, Effects& effects);
  void FinishEnergy(const Block& block, Effects& effects);
  void FinishBlock(const Block& block, Effects& effects);
  NodeId EnergyAtEdge(const Block& block, NodeId energy, Span span);

  // --- expressions (check_expressions.cpp)
  Value Evaluate(const Expression& tree);
  Value EvaluateNumber(const Expression& tree);
  Value EvaluateName(const Expression& tree);
  Value EvaluateMember(const Expression& tree);
  Value EvaluateBinary(const Expression& tree);
  Value EvaluateSum(const Expression& tree, Value left, Value right);
  Value EvaluateProduct(const Expression& tree, const Value& left, const Value& right);
  Value EvaluateQuotient(const Expression& tree, const Value& left, const Value& right);
  Value EvaluatePower(const Expression& tree);
  Value EvaluateComparison(const Expression& tree, const Value& left, const Value& right);
  Value EvaluateTuple(const Expression& tree);
  Value EvaluateConditional(const Expression& tree);
  Value EvaluateCall(const Expression& tree);
  Value CallOnNumbers(const Expression& tree, std::vector<Value>& arguments);
  Value CallOnVectors(const Expression& tree, std::vector<Value>& arguments);
  Value Number(NodeId node, const Dimension& dimension, Span span) const;
  Value LengthOf(const Value& vector, Span span);
  Value DirectionOf(const Value& vector, Span span);
  Value Rotated(const Value& rotation, const Value& vector, bool back, Span span);
  NodeId DotOf(const Value& a, const Value& b);
  void RequireNumber(const Value& value, const std::string& where);
  void RequireQuantity(const Value& value);
  void RequireSameUnit(Value& left, Value& right, const std::string& what, Span span,
                       const std::string& better = {});
  std::string ComparisonHint(const Value& value) const;
  std::string Bracketed(const Expression& sum, const Value& left, const Value& right);
  void RequireUnit(Value& value, const Dimension& expected, const std::string& what);
  void CheckUnitSymbols(const Expression& tree);

  // --- names (check_names.cpp)
  /// Returns the index of a property in the law's list; adds it to the list if it is new.
  uint16_t UseProperty(uint32_t property);
  uint16_t UseOwned(size_t owned);
  /// Returns the index of the values of a field at the positions of a participant's rows.
  uint16_t UseField(uint16_t participant, uint32_t field, Span span);
  /// Returns the index of the slope of a component of a field, at the positions of the property
  /// `values` of the law's list.
  uint16_t UseSlope(uint16_t values, uint16_t component);
  uint16_t AddField(const PropertyCode& use, const std::string& key);
  /// Returns the index of a field in the prototype; kNone if there is no field of this name.
  uint32_t FindField(std::string_view name) const;
  /// Finds a property of a kind by its name or by a common name for it. Returns kNone if there is
  /// no such property.
  uint32_t FindProperty(uint32_t kind, std::string_view name) const;
  size_t FindOwned(uint32_t kind, std::string_view name) const;
  /// Returns the index of the property `name` of a participant in the law's list. Reports a problem
  /// if the participant has no such property.
  uint16_t Resolve(uint16_t participant, const std::string& name, Span span);
  bool IsProperty(uint32_t kind, const std::string& name) const;
  Value ReadProperty(uint16_t participant, uint16_t property, Span span);
  uint32_t KindOfParticipant(uint16_t participant) const;
  bool IsKnown(const std::string& name) const;
  void RequireNewName(const Name& name);
  [[noreturn]] void FailUnknown(const std::string& name, Span span);
  std::vector<std::string> NamesInScope() const;
  std::string FactorHint(const std::string& which, const Dimension& found,
                         const Dimension& expected) const;

  std::string Source(Span span) const {
    return std::string(text_.substr(span.begin, span.end - span.begin));
  }
  /// Returns a part of the text in quotation marks, shortened if it is long.
  std::string Quoted(Span span) const;
  std::string Plural(uint32_t kind) const;

  std::string_view text_;
  const LawTree& tree_;
  const Prototype& prototype_;
  Problems& problems_;
  LawCode code_;
  Graph& graph_ = code_.graph;
  uint32_t world_kind_;
  bool uses_axes_ = false;
  bool uses_stage_ = false;
  bool added_force_ = false;

  struct Parameter {
    std::string name;
    Value value;
  };
  std::vector<Parameter> parameters_;
  std::vector<Owned> owned_;
  std::vector<std::pair<std::string, uint16_t>> used_;  // "kind.name" of each property, and its
                                                        // index in code_

  // The block that is being checked.
  const Block* block_ = nullptr;
  PassCode* pass_ = nullptr;
  Effects* effects_ = nullptr;
  std::vector<std::pair<std::string, Value>> lets_;
  /// Names whose declarations have a problem. Formulas that use them get no further problem.
  std::set<std::string> failed_;
  static constexpr size_t kMostLets = 2000;
  size_t checked_lets_ = 0;    // number of `let` statements checked so far, counting each block of
                               // the law
  uint32_t row_kind_ = kNone;  // kind of the block's rows; kNone if it has no row of its own
  std::vector<std::pair<std::string, uint32_t>> participants_;  // name and kind of each participant
  std::array<NodeId, 3> separation_{kNoNode, kNoNode, kNoNode};
  NodeId distance_ = kNoNode;
  std::array<NodeId, 3> direction_{kNoNode, kNoNode, kNoNode};
};

}  // namespace vesper::text
