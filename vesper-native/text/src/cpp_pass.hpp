// SPDX-License-Identifier: Apache-2.0
// Writes one pass of a law as C++.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cpp_names.hpp"
#include "cpp_terms.hpp"

namespace vesper::text {

/// The names of a law's members in generated code, by their indices in the law.
struct CppMembers {
  std::vector<std::string> properties;
  std::vector<std::string> parameters;
  std::string parameter_value = ".value()";  // follows the name of a parameter
  std::string neighbours;  // the search for pairs within a distance; empty if there is none
  // Names of members with values of the last step, on which an energy may depend.
  std::string last_time, last_dt, last_stage;
};

/// Features that generated code needs outside of a pass.
struct CppNeeds {
  bool grain = false;
  bool constants_of_world = false;  // the function First
  bool optional_columns = false;    // the function ValueOrZero
  bool algorithms = false;          // std::min, std::max
  bool limits = false;
  bool step = false;        // the argument `step` is used
  bool last_step = false;   // an energy depends on time, dt or the stage
  bool finite = false;      // the function RequireFinite
  bool precisions = false;  // the functions To and Store
};

/// Writes the statements of one pass: its results, or its energy.
class PassWriter {
 public:
  /// `names`: the names of the law's members, to which local names are added.
  PassWriter(const LawCode& law, const PassCode& pass, const CppMembers& members, CppNames names,
             bool energy, CppNeeds& needs);

  /// Returns the lines of the pass, indented by `indent` blanks.
  std::string Write(int indent);
  /// Returns the statements that compute a field at one place, indented by `indent` blanks. The
  /// names of `members` are those in the function of the field.
  std::string WriteField(const FieldCode& field, int indent);

 private:
  /// A result: a number or a vector that is stored in a property or added to it.
  struct Root {
    const Output* output;
    bool vector;
    TermId term;
    std::string local;  // name of the variable with the new value, if there is one
  };

  void MakeRoots();
  void Analyse();
  void AnalyseTerm(TermId id);
  bool IsUniformLocal(TermId id) const;
  void NameLocals();
  void NameFields();
  void NameRows();
  std::string RowsOfPass();

  void Line(const std::string& line);
  void Open(const std::string& line);
  void Close(const std::string& line = "}");
  void WriteUniforms();
  void WriteFields();
  void WriteLocals();
  void WriteResults();
  void WriteResult(const Root& root);
  void WriteBody();
  void WriteLoop();
  void WriteLoopOverRows();

  /// Returns a term as an expression for one row. The expression is in brackets if it binds less
  /// strongly than `least`.
  std::string Row(TermId id, int least);
  /// Returns a term for a place where a plain whole number would have the wrong type.
  std::string Typed(TermId id, int least = 0);
  std::string RowVector(const Term& term, int least);
  /// Returns a term that is the same for all rows, in double precision.
  std::string Uniform(TermId id, int least);
  std::string OperationText(const Term& term, int least, bool uniform);
  std::string Literal(double value);
  bool IsZeroVector(const Term& term) const;
  /// Returns a value of a property in the precision of the law.
  std::string LoadOf(const Load& load, bool whole);
  /// Returns the element of a column, or of one of its components.
  std::string ElementOf(const Load& load, bool whole);
  /// Converts a value of a property to the precision of the law, if it has another precision.
  std::string Converted(const PropertyCode& property, std::string value, bool vector);
  void StoreConverted(const Root& root);
  std::string TypeOf(const Term& term) const;
  std::string OfStep(TermKind kind);
  std::string OfParameter(uint32_t index) const;
  const std::string& RowOf(uint16_t participant) const;
  bool Reads(const Load& load) const;

  const LawCode& law_;
  const PassCode& pass_;
  const CppMembers& members_;
  CppNames names_;
  const bool energy_;
  CppNeeds& needs_;
  Terms terms_;
  std::vector<Root> roots_;
  std::vector<uint32_t> uses_;      // number of terms and results that use each term
  std::vector<bool> used_in_rows_;  // whether a row's term or result uses each term
  std::vector<uint32_t> sizes_;
  std::vector<std::string> locals_;  // variable of each term; empty: none
  std::string row_;                  // the variable of the block's row
  std::vector<std::string> participants_;
  bool of_field_ = false;
  /// Variables with the values of fields, by participant and property.
  std::map<std::pair<uint16_t, uint16_t>, std::string> fields_;
  std::string lines_;
  int indent_ = 0;
};

}  // namespace vesper::text
