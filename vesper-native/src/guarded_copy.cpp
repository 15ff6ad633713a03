// SPDX-License-Identifier: Apache-2.0
#include "guarded_copy.hpp"

#include <algorithm>
#include <cstring>

namespace vesper {
namespace {

constexpr std::byte kPattern{0xa5};

bool IsIntact(const std::byte* canary, size_t size) {
  return std::all_of(canary, canary + size, [](std::byte b) { return b == kPattern; });
}

}  // namespace

void GuardedCopy::Resize(size_t size) {
  buffer_.Resize(kCanary + size + kCanary);
  size_ = size;
  std::memset(buffer_.data(), static_cast<int>(kPattern), kCanary);
  std::memset(data() + size, static_cast<int>(kPattern), kCanary);
}

bool GuardedCopy::FrontIntact() const { return IsIntact(buffer_.data(), kCanary); }

bool GuardedCopy::BackIntact() const { return IsIntact(data() + size_, kCanary); }

}  // namespace vesper
