// SPDX-License-Identifier: Apache-2.0
// What a law library says about itself: checked, and copied, before anybody relies on it.
#pragma once

#include <string>
#include <vector>

#include "vesper/law.h"

namespace vesper {

/// More laws, uses or parameters than any library has; catches uninitialised counts.
inline constexpr uint32_t kMaxTableEntries = 256;

/// A library's tables in the structs of this build, whatever minor version it was built for. What
/// they point to outside (names, functions) remains the library's.
class LawTable {
 public:
  /// Throws ABI_MISMATCH, having read nothing but the first two fields, if the major version
  /// differs, or if the library asks for what only a newer contract has; LIBRARY_LOAD_FAILED if
  /// the tables break the contract of law.h. `source` names the library in messages.
  LawTable(const vesper_law_library* library, const char* source);
  LawTable(LawTable&&) = default;
  LawTable(const LawTable&) = delete;
  LawTable& operator=(const LawTable&) = delete;

  const vesper_law_library& library() const { return library_; }

 private:
  void ReadLaws(const std::string& where);

  vesper_law_library library_{};
  std::vector<vesper_law_desc> laws_;
  std::vector<vesper_field_desc> fields_;
  std::vector<std::vector<vesper_property_use>> uses_;  // of each law
  std::vector<std::vector<vesper_parameter_desc>> parameters_;
};

}  // namespace vesper
