// SPDX-License-Identifier: Apache-2.0
// How a failed operation travels inside the engine: as an exception up to the C border, where
// `Guarded` turns it into a status and fills the caller's `vesper_error`.
#pragma once

#include <exception>
#include <new>
#include <string_view>

#include "vesper/types.h"

namespace vesper {

/// A status with everything a `vesper_error` says. The message is one line, cut to fit.
class Failure {
 public:
  [[gnu::format(printf, 3, 4)]] Failure(vesper_status status, const char* format, ...);
  explicit Failure(const vesper_error& error) : error_(error) {}

  Failure& Library(vesper_library_id id) { return error_.library_id = id, *this; }
  Failure& Law(uint32_t index) { return error_.law_index = index, *this; }
  Failure& Stage(uint32_t stage) { return error_.stage = stage, *this; }
  Failure& Row(uint64_t row) { return error_.row = row, *this; }
  Failure& Property(std::string_view name);
  /// Puts `context` and ": " in front of the message.
  Failure& Within(std::string_view context);

  vesper_status status() const { return error_.status; }
  const vesper_error& error() const { return error_; }

 private:
  vesper_error error_;
};

/// An error that says nothing yet, for laws to fill.
vesper_error BlankError();

/// Makes every control character of a message that came from outside harmless, and ends it.
void Sanitize(vesper_error& error);

/// Name of a status, e.g. "NOT_FOUND"; static.
const char* StatusName(vesper_status status);

/// Runs `body` at the C border: no exception leaves, `error` is written on failure only.
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
