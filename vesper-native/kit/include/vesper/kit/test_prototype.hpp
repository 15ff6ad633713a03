// SPDX-License-Identifier: Apache-2.0
// The properties that exist in worlds of tests.
#pragma once

#include <string>

#include "vesper/types.h"

namespace vesper {

/// Returns the prototype of worlds of tests in one precision: `si-f64` or `si-f32`, or the
/// prototype that extends them after UseTestPrototype.
const vesper_prototype& TestPrototype(vesper_scalar_type real_type);

/// Makes all later tests of this process use a prototype file. The file extends `si-f64` or
/// `si-f32`; tests in the other precision use the same properties in that precision. Throws
/// std::runtime_error whose message names file, line and column. Not thread-safe.
void UseTestPrototype(const std::string& path);

}  // namespace vesper
