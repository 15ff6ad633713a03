// SPDX-License-Identifier: Apache-2.0
// Escaping of untrusted text in messages. The class reve.core.text.Visible does the same in Java.
#pragma once

#include <string>
#include <string_view>

namespace vesper::cli {

/// Returns the text with each unsafe character replaced by a backslash and `u{HEX}`. Unsafe are
/// control characters, because terminals execute them, controls of the writing direction, invisible
/// characters, and bytes that are no UTF-8. Line ends are not replaced.
std::string Visible(std::string_view text);

}  // namespace vesper::cli
