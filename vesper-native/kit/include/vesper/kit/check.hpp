// SPDX-License-Identifier: Apache-2.0
// What every law library promises, as checks made from its own declaration.
#pragma once

#include <chrono>
#include <span>
#include <string>

#include "vesper/types.h"

namespace vesper {

/// What a check is run on.
struct Subject {
  std::string file;              // of the library, a path
  vesper_scalar_type real_type;  // precision; 0 for checks of the file as a whole
};

struct Check {
  const char* name;     // "same-bits"
  const char* promise;  // one line
  bool per_precision;
  /// Returns a note for the report, perhaps empty. Throws what it found wrong, or whatever
  /// the engine throws, which fails the check too.
  std::string (*run)(const Subject&);
};

/// All checks, in the order in which they are run: the file first, then the law on its arrays.
std::span<const Check> Checks();

enum class Verdict { kPass, kFail, kSkip };

struct CheckOutcome {
  Verdict verdict;
  std::string note;  // what was measured, or the reason
};

/// Runs a check in a process of its own, because a law may crash or hang. The calling process must
/// have one thread.
CheckOutcome RunCheck(const Check& check, const Subject& subject,
                      std::chrono::seconds limit = std::chrono::seconds(60));

}  // namespace vesper
