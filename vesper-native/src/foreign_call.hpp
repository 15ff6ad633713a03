// SPDX-License-Identifier: Apache-2.0
// Calls of functions of law libraries.
#pragma once

#include <exception>
#include <string>

#include "failure.hpp"
#include "floating_point.hpp"
#include "loop_bound.hpp"

namespace vesper {

/// Returns a LAW_FAILED failure with the status and the message of the library. The proxy of a law
/// that runs apart keeps LAW_CRASHED and LAW_TIMED_OUT.
inline Failure ForeignFailure(const std::string& caller, vesper_status status, vesper_error error) {
  if (error.message[0] == '\0') {
    return Failure(VESPER_LAW_FAILED, "%s: returned status %d (%s)", caller.c_str(), status,
                   StatusName(status));
  }
  Sanitize(error);
  error.status =
      status == VESPER_LAW_CRASHED || status == VESPER_LAW_TIMED_OUT ? status : VESPER_LAW_FAILED;
  return Failure(error).Within(caller);
}

/// Runs `call(vesper_error*)` under default floating-point modes. Throws LAW_FAILED, naming
/// `caller`, if the call returns another status than VESPER_OK or throws, and LAW_MISBEHAVED if it
/// asked for a loop that is too long.
template <class Call>
void CallForeign(const std::string& caller, Call&& call) {
  vesper_error error = BlankError();
  vesper_status status;
  try {
    const FloatingPointGuard guard;
    status = call(&error);
  } catch (const std::exception& exception) {
    throw Failure(VESPER_LAW_FAILED, "%s: threw: %s", caller.c_str(), exception.what());
  } catch (...) {
    throw Failure(VESPER_LAW_FAILED, "%s: threw an exception of unknown type", caller.c_str());
  }
  ReportRefusedLoop(caller + ": ");
  if (status != VESPER_OK) throw ForeignFailure(caller, status, error);
}

/// Runs a call that returns no status, under default floating-point modes. Ignores its exceptions.
template <class Call>
void CallForeignQuietly(Call&& call) noexcept {
  try {
    const FloatingPointGuard guard;
    call();
  } catch (...) {
  }
}

}  // namespace vesper
