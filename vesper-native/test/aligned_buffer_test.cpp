// SPDX-License-Identifier: Apache-2.0
// Tests moves of an aligned buffer between owners.
#include "aligned_buffer.hpp"

#include <gtest/gtest.h>

namespace vesper {
namespace {

TEST(AlignedBufferTest, MovedFromIsEmptyAndCanBeUsedAgain) {
  AlignedBuffer first;
  first.Resize(100);
  first.data()[99] = std::byte{7};
  AlignedBuffer second = std::move(first);
  EXPECT_EQ(second.size(), 100u);
  EXPECT_EQ(second.data()[99], std::byte{7});
  EXPECT_EQ(first.size(), 0u);
  first.Resize(50);  // within the old capacity
  ASSERT_NE(first.data(), nullptr);
  first.data()[49] = std::byte{8};
  second = std::move(first);
  EXPECT_EQ(second.size(), 50u);
  EXPECT_EQ(second.data()[49], std::byte{8});
  EXPECT_EQ(first.size(), 0u);
}

}  // namespace
}  // namespace vesper
