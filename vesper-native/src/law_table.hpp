// Checks what a law library says about itself, before anybody relies on it.
#pragma once

#include "struct_array.hpp"
#include "vesper/law.h"

namespace vesper {

/// More laws, uses or parameters than any library has; catches uninitialised counts.
inline constexpr uint32_t kMaxTableEntries = 256;

/// Throws ABI_MISMATCH, reading nothing but the first two fields, or LIBRARY_LOAD_FAILED if the
/// rest of the table breaks the contract of law.h. `source` names the library in messages.
void CheckLawLibrary(const vesper_law_library* library, const char* source);

/// The fields of a library; none if it was built before there were any.
StructArray<vesper_field_desc> FieldsOf(const vesper_law_library& library);

}  // namespace vesper
