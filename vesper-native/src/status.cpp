// SPDX-License-Identifier: Apache-2.0
#include "failure.hpp"

namespace vesper {

const char* StatusName(vesper_status status) {
  switch (status) {
    case VESPER_OK:
      return "OK";
    case VESPER_INVALID_ARGUMENT:
      return "INVALID_ARGUMENT";
    case VESPER_NOT_FOUND:
      return "NOT_FOUND";
    case VESPER_ALREADY_EXISTS:
      return "ALREADY_EXISTS";
    case VESPER_BUSY:
      return "BUSY";
    case VESPER_ABI_MISMATCH:
      return "ABI_MISMATCH";
    case VESPER_TYPE_MISMATCH:
      return "TYPE_MISMATCH";
    case VESPER_UNIT_MISMATCH:
      return "UNIT_MISMATCH";
    case VESPER_COUNT_MISMATCH:
      return "COUNT_MISMATCH";
    case VESPER_ACCESS_CONFLICT:
      return "ACCESS_CONFLICT";
    case VESPER_LIBRARY_LOAD_FAILED:
      return "LIBRARY_LOAD_FAILED";
    case VESPER_LAW_FAILED:
      return "LAW_FAILED";
    case VESPER_LAW_MISBEHAVED:
      return "LAW_MISBEHAVED";
    case VESPER_FAULTED:
      return "FAULTED";
    case VESPER_INTERNAL:
      return "INTERNAL";
    case VESPER_LAW_CRASHED:
      return "LAW_CRASHED";
    case VESPER_LAW_TIMED_OUT:
      return "LAW_TIMED_OUT";
  }
  return "UNKNOWN";
}

}  // namespace vesper
