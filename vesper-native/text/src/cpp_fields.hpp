// SPDX-License-Identifier: Apache-2.0
// Writes the fields that the laws of a text provide as C++.
#pragma once

#include <string>
#include <vector>

#include "cpp_names.hpp"
#include "cpp_pass.hpp"
#include "law_code.hpp"

namespace vesper::text {

/// Writes the functions of all fields of a text. They read the parameters of their laws, and the
/// time of the step, from the suite of the library. Writes nothing if the text provides no field.
class FieldsWriter {
 public:
  /// `names`: the names of the file, to which the names of the suite and the functions are added.
  /// The laws must outlive this object.
  FieldsWriter(const std::vector<LawCode>& laws, CppNames& names);

  /// Returns the class of the suite.
  std::string Suite() const;
  /// Returns the members by which a law passes its parameters to the suite. `parameters`: names of
  /// the law's parameters.
  std::string Join(const LawCode& law, const std::vector<std::string>& parameters) const;
  /// Returns the functions of the fields, and their table `kFields`.
  std::string Functions(CppUnits& units, CppNeeds& needs) const;

 private:
  struct LawOfFields {
    const LawCode* law;
    std::vector<std::string> parameters;  // names in the suite
  };
  const LawOfFields& Of(const LawCode& law) const;

  std::vector<LawOfFields> laws_;
  bool any_ = false;
  std::string suite_;               // name of the class
  std::vector<std::string> names_;  // of the functions, by field
};

}  // namespace vesper::text
