// SPDX-License-Identifier: Apache-2.0
// A checked copy of the tables of a law library.
#pragma once

#include <string>
#include <vector>

#include "vesper/law.h"

namespace vesper {

/// Maximum number of laws, uses or parameters in a library; detects uninitialised counts.
inline constexpr uint32_t kMaxTableEntries = 256;

/// The tables of a library. They are converted from the structs of any minor version to the structs
/// of this build. Names and functions remain in the library.
class LawTable {
 public:
  /// Reads the tables. Throws ABI_MISMATCH if the major version differs (then only the first two
  /// fields were read), or if the library requires features of a newer contract. Throws
  /// LIBRARY_LOAD_FAILED if the tables violate the contract of law.h. `source` names the library in
  /// messages.
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
  std::vector<std::vector<vesper_property_use>> uses_;  // uses of each law
  std::vector<std::vector<vesper_parameter_desc>> parameters_;
};

}  // namespace vesper
