// SPDX-License-Identifier: Apache-2.0
// Compares the scan for NaN and infinity with the standard library's classification.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "kernels.hpp"

namespace vesper {
namespace {

template <class Real>
class FiniteTest : public testing::Test {
 protected:
  static constexpr vesper_scalar_type kType = sizeof(Real) == 4 ? VESPER_F32 : VESPER_F64;
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(FiniteTest, Reals);

TYPED_TEST(FiniteTest, FindsEveryNonFiniteValueAtEveryPlace) {
  using Limits = std::numeric_limits<TypeParam>;
  for (const TypeParam bad : {Limits::quiet_NaN(), -Limits::quiet_NaN(), Limits::signaling_NaN(),
                              Limits::infinity(), -Limits::infinity()}) {
    for (const size_t count : {1u, 2u, 7u, 4095u, 4096u, 4097u, 9000u}) {
      std::vector<TypeParam> values(count, TypeParam{1});
      for (const size_t at : {size_t{0}, count / 2, count - 1}) {
        values[at] = bad;
        EXPECT_EQ(FindNonFinite(this->kType, values.data(), count), at) << bad << " of " << count;
        values[at] = 1;
      }
    }
  }
}

TYPED_TEST(FiniteTest, AcceptsEveryFiniteExtreme) {
  using Limits = std::numeric_limits<TypeParam>;
  const std::vector<TypeParam> values = {0,
                                         -TypeParam{0},
                                         Limits::max(),
                                         Limits::lowest(),
                                         Limits::min(),
                                         Limits::denorm_min(),
                                         -Limits::denorm_min()};
  EXPECT_EQ(FindNonFinite(this->kType, values.data(), values.size()), kNotFound);
}

TYPED_TEST(FiniteTest, ImmenseValuesBeginAtTwoToThe333) {
  constexpr bool kDouble = sizeof(TypeParam) == 8;
  const double limit = std::ldexp(1.0, 333);
  const auto find = [](double value) {
    const auto real = static_cast<TypeParam>(value);
    return FindImmense(FiniteTest<TypeParam>::kType, &real, 1);
  };
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(find(sign * std::nextafter(limit, 0)), kDouble ? kNotFound : 0u);
    EXPECT_EQ(find(sign * limit), 0u);
    EXPECT_EQ(find(sign * 1e300), 0u);
    EXPECT_EQ(find(sign * std::numeric_limits<double>::infinity()), 0u);
    EXPECT_EQ(find(sign * 1e38), kNotFound);
    EXPECT_EQ(find(sign * 1e-320), kNotFound);
    EXPECT_EQ(find(sign * 0), kNotFound);
  }
  EXPECT_EQ(find(std::nan("")), 0u);
  const uint32_t integer = 0xffffffff;
  EXPECT_EQ(FindImmense(VESPER_U32, &integer, 1), kNotFound);
}

TYPED_TEST(FiniteTest, AgreesWithIsfiniteOnRandomBits) {
  constexpr uint64_t kSeed = 77;
  std::mt19937_64 random(kSeed);
  for (int i = 0; i < 200000; ++i) {
    const uint64_t bits = random();
    TypeParam value;
    std::memcpy(&value, &bits, sizeof value);
    const uint64_t expected = std::isfinite(value) ? kNotFound : 0;
    ASSERT_EQ(FindNonFinite(this->kType, &value, 1), expected) << bits << ", seed " << kSeed;
  }
}

TYPED_TEST(FiniteTest, MarkOfUnwrittenValuesIsNotFinite) {
  TypeParam values[3] = {1, 2, 3};
  FillUnwritten(this->kType, values, 3);
  EXPECT_EQ(FindNonFinite(this->kType, values, 3), 0u);
  EXPECT_TRUE(IsUnwritten(this->kType, values, 2));
  values[2] = std::numeric_limits<TypeParam>::quiet_NaN();
  EXPECT_FALSE(IsUnwritten(this->kType, values, 2));
}

}  // namespace
}  // namespace vesper
