// SPDX-License-Identifier: Apache-2.0
// Checks of a library's file and of its declarations.
#include <regex>
#include <span>

#include "subject.hpp"

namespace vesper {
namespace {

std::string Quote(const std::string& text) { return "'" + text + "'"; }

void ExpectLaw(const vesper_law_desc& law) {
  const std::string name = Quote(law.name);
  Expect(std::regex_match(law.name, std::regex("[a-z][a-z0-9_]*")), name + " is not snake_case");
  Expect(std::regex_match(law.version, std::regex("\\d+\\.\\d+\\.\\d+")),
         name + " has version " + Quote(law.version) + ", expected major.minor.patch");
  Expect(law.doc != nullptr && *law.doc != '\0', name + " has no doc");
  Expect(law.phase >= VESPER_PHASE_FORCE && law.phase <= VESPER_PHASE_OBSERVE,
         name + " has no phase");
  Expect((law.stages > 0) == (law.phase == VESPER_PHASE_INTEGRATE),
         name + ": only integrators have stages, at least one");
  Expect(law.use_count > 0, name + " uses no property");
  Expect(law.create && law.bind && law.advance && law.destroy, name + " lacks a callback");
  for (const auto& parameter : std::span(law.parameters, law.parameter_count)) {
    const std::string of = name + ", parameter " + Quote(parameter.name);
    Expect(parameter.minimum <= parameter.default_value &&
               parameter.default_value <= parameter.maximum,
           of + ": the default is outside its limits");
    Expect(parameter.doc != nullptr && *parameter.doc != '\0', of + " has no doc");
  }
}

void ExpectSameDeclaration(const vesper_law_desc& f32, const vesper_law_desc& f64) {
  const std::string name = Quote(f64.name);
  Expect(f32.name == std::string(f64.name), name + " and " + Quote(f32.name));
  Expect(f32.claims == f64.claims, name + " claims other things");
  Expect(f32.use_count == f64.use_count, name + " uses another number of properties");
  for (uint32_t u = 0; u < f32.use_count; ++u) {
    const vesper_property_use &a = f32.uses[u], &b = f64.uses[u];
    Expect(a.name == std::string(b.name),
           name + " uses " + Quote(a.name) + " and " + Quote(b.name));
    Expect(a.access == b.access, name + " accesses " + Quote(a.name) + " in another way");
    const bool real = a.scalar_type == VESPER_F32 && b.scalar_type == VESPER_F64;
    Expect(real || a.scalar_type == b.scalar_type, name + " has another type for " + Quote(a.name));
  }
}

}  // namespace

std::string CheckExports(const Subject& subject) {
  const LawFile library(subject.file);
  if (!library.is_native()) throw CheckSkipped("is not a shared object");
  for (const std::string& name : library.Exports()) {
    Expect(name == VESPER_LAW_LIBRARY_ENTRY,
           "also exports " + Quote(name) + "; build it with vesper_add_law");
  }
  return "";
}

std::string CheckImports(const Subject& subject) {
  // The runtime library of a sanitizer is permitted, because the author of a law links it to find
  // faults.
  const std::string standard =
      "libc\\.so\\.6|libm\\.so\\.6|libstdc\\+\\+\\.so\\.6|libgcc_s\\.so\\.1|"
      "ld-linux[^/]*\\.so\\.[0-9]+|lib(asan|lsan|tsan|ubsan)\\.so\\.[0-9]+";
  const std::regex file(standard), provider(".*\\((" + standard + ").*\\)");
  const LawFile library(subject.file);
  if (!library.is_native()) throw CheckSkipped("is not a shared object");
  for (const std::string& needed : library.Needed()) {
    Expect(std::regex_match(needed, file), "needs the library " + Quote(needed));
  }
  for (const std::string& import : library.Imports()) {
    Expect(std::regex_match(import, provider), "takes the symbol " + import);
  }
  return "";
}

std::string CheckTable(const Subject& subject) {
  const LawFile library(subject.file);
  const vesper_law_library& table = library.table();
  Expect(table.name == LawFile::NameOf(subject.file),
         "calls itself " + Quote(table.name) + "; expected the name in its file's, " +
             LawFile::FileNameFor(subject.file, table.name));
  Expect((table.open == nullptr) == (table.close == nullptr), "has one of open and close");
  Expect(table.law_count > 0, "has no law");
  for (const auto& law : std::span(table.laws, table.law_count)) ExpectLaw(law);
  return "";
}

std::string CheckPrecisions(const Subject& subject) {
  const LawFile library(subject.file);
  const auto f32 = library.Laws(VESPER_F32), f64 = library.Laws(VESPER_F64);
  if (f32.empty() || f64.empty()) throw CheckSkipped("has laws in one precision only");
  Expect(f32.size() == f64.size(), "has " + std::to_string(f32.size()) + " laws in f32 and " +
                                       std::to_string(f64.size()) + " in f64");
  for (size_t i = 0; i < f32.size(); ++i) ExpectSameDeclaration(*f32[i], *f64[i]);
  return "";
}

}  // namespace vesper
