// SPDX-License-Identifier: Apache-2.0
// Tests structs of older and newer minor versions of the contract.
#include "versioned_struct.hpp"

#include <gtest/gtest.h>

namespace vesper {
namespace {

/// The struct of this build, in which `later` was appended to the first version.
struct Grown {
  uint32_t struct_size;
  uint32_t first;
  uint64_t later;
};
/// The struct of a newer contract.
struct Future {
  Grown known;
  uint64_t unheard_of;
};

}  // namespace

template <>
inline constexpr uint32_t kFirstSize<Grown> = 8;

namespace {

template <class Call>
void ExpectRefused(vesper_status status, const std::string& text, Call&& call) {
  try {
    call();
    ADD_FAILURE() << "not refused: " << text;
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status(), status);
    EXPECT_NE(std::string(failure.error().message).find(text), std::string::npos)
        << failure.error().message;
  }
}

TEST(VersionedStructTest, FieldThatAnOlderSideDoesNotHaveIsZero) {
  const Grown older{8, 5, 77};  // the bytes after its first 8 do not belong to it
  const Grown read = ReadStruct(older, "it");
  EXPECT_EQ(read.first, 5u);
  EXPECT_EQ(read.later, 0u);
  EXPECT_EQ(read.struct_size, sizeof(Grown));
}

TEST(VersionedStructTest, NewerSideIsServedUnlessItAsksForMore) {
  Future newer{{sizeof(Future), 5, 6}, 0};
  EXPECT_EQ(ReadStruct(newer.known, "it").later, 6u);
  newer.unheard_of = 1;
  ExpectRefused(VESPER_ABI_MISMATCH, "it uses a field that contract 1.",
                [&] { ReadStruct(newer.known, "it"); });
}

TEST(VersionedStructTest, ArraysAreWalkedByTheSizeOfTheirElements) {
  const Future newer[] = {{{sizeof(Future), 1, 2}, 0}, {{sizeof(Future), 3, 4}, 0}};
  const auto read = ReadStructs(&newer[0].known, 2, "them");
  EXPECT_EQ(read[1].first, 3u);
  EXPECT_EQ(read[1].later, 4u);
  const uint32_t older[] = {8, 1, 8, 3};
  const auto old = ReadStructs(reinterpret_cast<const Grown*>(older), 2, "them");
  EXPECT_EQ(old[1].first, 3u);
  EXPECT_EQ(old[1].later, 0u);
  const uint32_t mixed[] = {8, 1, 16, 3};
  ExpectRefused(VESPER_INVALID_ARGUMENT, "them[1].struct_size is 16, expected 8 as in [0]",
                [&] { ReadStructs(reinterpret_cast<const Grown*>(mixed), 2, "them"); });
}

TEST(VersionedStructTest, NothingIsWrittenBehindAnOlderStruct) {
  Grown older{8, 0, 77};
  WriteStruct(older, {sizeof(Grown), 5, 6}, "out");
  EXPECT_EQ(older.struct_size, 8u);
  EXPECT_EQ(older.first, 5u);
  EXPECT_EQ(older.later, 77u);
}

TEST(VersionedStructTest, WhatThisBuildDoesNotKnowIsZeroInANewerStruct) {
  Future newer{{sizeof(Future), 0, 0}, 99};
  WriteStruct(newer.known, {sizeof(Grown), 5, 6}, "out");
  EXPECT_EQ(newer.known.struct_size, sizeof(Future));
  EXPECT_EQ(newer.known.later, 6u);
  EXPECT_EQ(newer.unheard_of, 0u);
}

TEST(VersionedStructTest, SizesThatNoVersionHadAreRefused) {
  for (const uint32_t size : {0u, 4u, 9u, 5000u}) {
    ExpectRefused(VESPER_INVALID_ARGUMENT, "it.struct_size is " + std::to_string(size),
                  [&] { ReadStruct(Grown{size, 0, 0}, "it"); });
  }
}

}  // namespace
}  // namespace vesper
