// SPDX-License-Identifier: Apache-2.0
#include "visible.hpp"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace vesper::cli {
namespace {

constexpr char32_t kNoCharacter = 0xfffd;  // represents bytes that are no UTF-8

struct Range {
  char32_t first, last;
};
/// The characters that Visible escapes: Unicode's controls, separators, characters for private use,
/// and format characters except the two joiners.
constexpr Range kUnsafe[] = {
    {0, 0x09},          {0x0b, 0x1f},     {0x7f, 0x9f},     {0xa0, 0xa0},     {0xad, 0xad},
    {0x0600, 0x0605},   {0x061c, 0x061c}, {0x06dd, 0x06dd}, {0x070f, 0x070f}, {0x1680, 0x1680},
    {0x180e, 0x180e},   {0x2000, 0x200b}, {0x200e, 0x200f}, {0x2028, 0x202f}, {0x205f, 0x206f},
    {0x3000, 0x3000},   {0xd800, 0xf8ff}, {0xfeff, 0xfeff}, {0xfff9, 0xfffd}, {0x1d173, 0x1d17a},
    {0xe0000, 0x10ffff}};

bool IsSafe(char32_t character) {
  for (const auto& [first, last] : kUnsafe) {
    if (character >= first && character <= last) return false;
  }
  return true;
}

/// Returns the first character, and its length in bytes.
std::pair<char32_t, size_t> Decode(std::string_view text) {
  const auto lead = static_cast<uint8_t>(text[0]);
  if (lead < 0x80) return {lead, 1};
  const auto length = static_cast<size_t>(std::countl_one(lead));
  if (length < 2 || length > 4 || length > text.size()) return {kNoCharacter, 1};
  char32_t character = lead & (0x7fU >> length);
  for (const char next : text.substr(1, length - 1)) {
    if ((static_cast<uint8_t>(next) & 0xc0) != 0x80) return {kNoCharacter, 1};
    character = (character << 6) | (static_cast<uint8_t>(next) & 0x3f);
  }
  constexpr char32_t kLeast[] = {0x80, 0x800, 0x10000};  // shorter forms are no UTF-8
  if (character < kLeast[length - 2]) return {kNoCharacter, 1};
  return {character, length};
}

}  // namespace

std::string Visible(std::string_view text) {
  std::string visible;
  while (!text.empty()) {
    const auto [character, length] = Decode(text);
    if (IsSafe(character)) {
      visible += text.substr(0, length);
    } else {
      char escape[16];
      std::snprintf(escape, sizeof escape, "\\u{%x}", static_cast<unsigned>(character));
      visible += escape;
    }
    text.remove_prefix(length);
  }
  return visible;
}

}  // namespace vesper::cli
