// SPDX-License-Identifier: Apache-2.0
// A law text as a law library.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "prototype.hpp"
#include "syntax.hpp"
#include "vesper/law.h"

namespace vesper::text {

inline constexpr size_t kMaxText = 65536;  // maximum size of a text [byte]
inline constexpr size_t kMaxLaws = 16;     // maximum number of laws in one text
inline constexpr size_t kMaxFields = 16;   // maximum number of fields that one text provides

class CompiledText;

/// A text without syntax errors. `TableFor` checks it against the properties of a world.
class TextLibrary {
 public:
  /// Parses a text; `source` is its name for messages. Throws LIBRARY_LOAD_FAILED with the first
  /// problem.
  TextLibrary(std::string source, std::string text);
  ~TextLibrary();
  TextLibrary(const TextLibrary&) = delete;
  TextLibrary& operator=(const TextLibrary&) = delete;

  /// Returns the name of the first law.
  const std::string& name() const { return laws_.front().name.word; }
  /// Compiles the laws, in both precisions, for the properties of a prototype. The table lives as
  /// long as this object. Throws LIBRARY_LOAD_FAILED with the first problem.
  const vesper_law_library& TableFor(const Prototype& prototype);

 private:
  std::string source_;
  std::string text_;
  std::vector<LawTree> laws_;
  std::vector<std::unique_ptr<CompiledText>> compiled_;
};

/// Returns all problems of a text for a prototype, each with its line. Returns an empty text if
/// there are no problems.
std::string Report(std::string_view source, std::string_view text, const Prototype& prototype);

/// Translates a text to the C++ source of a law library. Throws LIBRARY_LOAD_FAILED with the first
/// problem.
std::string ToCpp(std::string_view source, std::string_view text, const Prototype& prototype);

}  // namespace vesper::text
