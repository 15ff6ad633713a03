// SPDX-License-Identifier: Apache-2.0
// The exception for failed operations inside the engine. At the C boundary, `Guarded` converts it
// to a status and fills the caller's `vesper_error`.
#pragma once

#include <exception>
#include <new>
#include <string_view>

#include "vesper/types.h"

namespace vesper {

/// A status with all fields of a `vesper_error`. The message is one line, truncated to fit.
class Failure {
 public:
  [[gnu::format(printf, 3, 4)]] Failure(vesper_status status, const char* format, ...);
  explicit Failure(const vesper_error& error) : error_(error) {}

  Failure& Library(vesper_library_id id) { return error_.library_id = id, *this; }
  Failure& Law(uint32_t index) { return error_.law_index = index, *this; }
  Failure& Stage(uint32_t stage) { return error_.stage = stage, *this; }
  Failure& Row(uint64_t row) { return error_.row = row, *this; }
  Failure& Property(std::string_view name);
  /// Prefixes the message with `context` and ": ".
  Failure& Within(std::string_view context);

  vesper_status status() const { return error_.status; }
  const vesper_error& error() const { return error_; }

 private:
  vesper_error error_;
};

/// Returns an empty error for a law to fill.
vesper_error BlankError();

/// Replaces control characters in a message from foreign code, and makes sure that it is
/// NUL-terminated.
void Sanitize(vesper_error& error);

/// Returns the name of a status, e.g. "NOT_FOUND"; static.
const char* StatusName(vesper_status status);

/// Runs `body` at the C boundary: converts an exception to a status, and writes `error` on failure
/// only.
template <class Body>
vesper_status Guarded(vesper_error* error, Body&& body) noexcept {
  const auto report = [error](const Failure& failure) {
    if (error != nullptr) *error = failure.error();
    return failure.status();
  };
  try {
    body();
    return VESPER_OK;
  } catch (const Failure& failure) {
    return report(failure);
  } catch (const std::bad_alloc&) {
    return report(Failure(VESPER_INTERNAL, "out of memory"));
  } catch (const std::exception& exception) {
    return report(Failure(VESPER_INTERNAL, "%s", exception.what()));
  } catch (...) {
    return report(Failure(VESPER_INTERNAL, "an exception of unknown type reached the C border"));
  }
}

}  // namespace vesper
