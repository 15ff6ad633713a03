// SPDX-License-Identifier: Apache-2.0
// PNG files from rows of pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace vesper::render {

/// 8-bit sRGB pixels, three bytes each, rows from the bottom of the picture to its top.
struct Pixels {
  uint32_t width = 0, height = 0;  ///< [px]
  std::vector<uint8_t> rgb;        ///< (height x width x 3)
};

/// Replaces `png` by the encoded picture. Throws std::runtime_error with libpng's reason.
void EncodePng(const Pixels& pixels, std::vector<std::byte>& png);

/// Writes a whole file under a temporary name in the same folder, then renames it, so that nobody
/// ever reads half a picture. Throws std::runtime_error naming the path and the reason.
void WriteFileAtOnce(const std::string& path, const std::vector<std::byte>& content);

}  // namespace vesper::render
