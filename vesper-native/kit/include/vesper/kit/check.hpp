// SPDX-License-Identifier: Apache-2.0
// Checks of the rules for law libraries, derived from each library's own declarations.
#pragma once

#include <chrono>
#include <span>
#include <string>

#include "vesper/types.h"

namespace vesper {

/// The object of a check: a library in one precision.
struct Subject {
  std::string file;              // path of the library
  vesper_scalar_type real_type;  // precision; 0 for checks of the file as a whole
};

struct Check {
  const char* name;     // "same-bits"
  const char* promise;  // one line
  bool per_precision;
  /// Runs the check and returns a note for the report, which may be empty. Throws a description of
  /// the failure; an exception of the engine also fails the check.
  std::string (*run)(const Subject&);
};

/// Returns all checks in execution order: first those of the file, then those of the law on its
/// arrays.
std::span<const Check> Checks();

enum class Verdict { kPass, kFail, kSkip };

struct CheckOutcome {
  Verdict verdict;
  std::string note;  // measured values, or the reason
};

/// Runs a check in a separate process, because a law may crash or hang. `limit` is the limit on the
/// processor time of the check; a check that waits instead fails after ten minutes. The calling
/// process must have one thread.
CheckOutcome RunCheck(const Check& check, const Subject& subject,
                      std::chrono::seconds limit = std::chrono::seconds(60));

}  // namespace vesper
