// SPDX-License-Identifier: Apache-2.0
// PNG encoder for rows of pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vesper::render {

/// 8-bit sRGB pixels, three bytes each, rows from bottom to top.
struct Pixels {
  uint32_t width = 0, height = 0;  ///< [px]
  std::vector<uint8_t> rgb;        ///< (height x width x 3)
};

/// Replaces the contents of `png` by the encoded picture. Throws std::runtime_error with libpng's
/// message.
void EncodePng(const Pixels& pixels, std::vector<std::byte>& png);

/// Writes a file under a temporary name in the same folder, then renames it, so that readers never
/// see a partial picture. Throws std::runtime_error with path and reason.
void WriteFileAtOnce(const std::string& path, const std::vector<std::byte>& content);

}  // namespace vesper::render
