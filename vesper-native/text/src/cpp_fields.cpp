// SPDX-License-Identifier: Apache-2.0
#include "cpp_fields.hpp"

#include <algorithm>

namespace vesper::text {

FieldsWriter::FieldsWriter(const std::vector<LawCode>& laws, CppNames& names) {
  any_ = std::ranges::any_of(laws, [](const LawCode& law) { return !law.fields.empty(); });
  if (!any_) return;
  suite_ = names.Take("Fields");
  names.Take("BeginStep");
  names.Take("kFields");
  CppNames members;
  members.Take("time");
  for (const LawCode& law : laws) {
    LawOfFields& of = laws_.emplace_back(LawOfFields{&law, {}});
    if (law.fields.empty()) continue;
    for (const ParameterCode& parameter : law.parameters) {
      of.parameters.push_back(members.Take(SnakeCase(law.name + "_" + parameter.name)));
    }
    for (const FieldCode& field : law.fields) {
      names_.push_back(names.Take("Evaluate" + PascalCase(field.name)));
    }
  }
}

const FieldsWriter::LawOfFields& FieldsWriter::Of(const LawCode& law) const {
  return *std::ranges::find(laws_, &law, &LawOfFields::law);
}

std::string FieldsWriter::Suite() const {
  if (!any_) return {};
  std::string text =
      "/** Numbers that the fields of this library depend on. */\nstruct " + suite_ + " {\n";
  for (const LawOfFields& of : laws_) {
    for (const std::string& name : of.parameters) text += "  double " + name + " = 0;\n";
  }
  return text + "  double time = 0;  // at the start of the step [s]\n};\n\n";
}

std::string FieldsWriter::Join(const LawCode& law,
                               const std::vector<std::string>& parameters) const {
  if (!any_) return {};
  const std::vector<std::string>& names = Of(law).parameters;
  std::string text = "\n  using Suite = " + suite_ + ";\n";
  text += "  void Join([[maybe_unused]] Suite& fields) {";
  for (size_t i = 0; i < names.size(); ++i) {
    text += "\n    fields." + names[i] + " = " + parameters[i] + ".value();";
  }
  return text + (names.empty() ? "}\n" : "\n  }\n");
}

std::string FieldsWriter::Functions(CppUnits& units, CppNeeds& needs) const {
  if (!any_) return {};
  static const PassCode kNoPass{};
  std::string functions, table;
  bool timed = false;
  size_t next = 0;
  for (const LawOfFields& of : laws_) {
    CppMembers members;
    for (const std::string& name : of.parameters) members.parameters.push_back("fields." + name);
    members.parameter_value = "";
    members.last_time = "fields.time";
    for (const FieldCode& field : of.law->fields) {
      CppNames names;
      for (const char* taken : {"user", "count", "at", "out", "fields", "i"}) names.Take(taken);
      const std::string& name = names_[next++];
      functions += "void " + name +
                   "(void* user, uint64_t count, const double* at, double* out) {\n" +
                   "  [[maybe_unused]] const auto& fields = *static_cast<const " + suite_ +
                   "*>(user);\n  for (uint64_t i = 0; i < count; ++i) {\n" +
                   PassWriter(*of.law, kNoPass, members, names, true, needs).WriteField(field, 4) +
                   "  }\n}\n\n";
      const bool of_time = field.program.DependsOnTime();
      timed = timed || of_time;
      table += "    {sizeof(vesper_field_desc), " + std::to_string(field.components) + ", " +
               CppString(field.name) + ", " + CppString(field.doc) + ",\n     " +
               units.Of(field.dimension) + ", " + name + ", " +
               (of_time ? "BeginStep" : "nullptr") + ", nullptr, nullptr},\n";
    }
  }
  if (timed) {
    functions += "void BeginStep(void* user, const vesper_step* step) {\n  static_cast<" + suite_ +
                 "*>(user)->time = step->time;\n}\n\n";
  }
  return functions + "constexpr vesper_field_desc kFields[] = {\n" + table + "};\n\n";
}

}  // namespace vesper::text
