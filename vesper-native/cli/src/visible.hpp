// SPDX-License-Identifier: Apache-2.0
// Escaping of untrusted text in messages, as reve.core.text.Visible does it in Java.
#pragma once

#include <string>
#include <string_view>

namespace vesper::cli {

/// Returns the text with each unsafe character as a backslash and `u{HEX}`: control characters,
/// which could command the terminal, controls of writing direction, invisible characters, and bytes
/// that are no UTF-8. Line ends stay.
std::string Visible(std::string_view text);

}  // namespace vesper::cli
