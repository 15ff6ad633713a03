// SPDX-License-Identifier: Apache-2.0
// The loops of the evaluator: the same bits for all instruction sets, and accurate functions.
#include "kernels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "evaluator.hpp"

namespace vesper::text {
namespace {

constexpr Operation kAll[] = {
    Operation::kAdd,    Operation::kSubtract, Operation::kMultiply,    Operation::kDivide,
    Operation::kNegate, Operation::kSqrt,     Operation::kAbs,         Operation::kMin,
    Operation::kMax,    Operation::kFloor,    Operation::kExp,         Operation::kLn,
    Operation::kSin,    Operation::kCos,      Operation::kTan,         Operation::kAsin,
    Operation::kAcos,   Operation::kAtan,     Operation::kAtan2,       Operation::kTanh,
    Operation::kPower,  Operation::kLess,     Operation::kLessOrEqual, Operation::kEqual,
    Operation::kAnd,    Operation::kOr,       Operation::kNot,         Operation::kSelect};

template <class Real>
class KernelsTest : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(KernelsTest, Precisions);

/// Values of all sizes, and special values such as infinity.
template <class Real>
std::vector<Real> Values(uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<Real> values;
  for (size_t i = 0; i < kBlock; ++i) {
    const double u = static_cast<double>(random()) / 4294967296.0;
    const double size = std::exp2(static_cast<double>(random() % 60) - 30);
    values.push_back(static_cast<Real>((u - 0.5) * (i % 3 == 0 ? 4 : size)));
  }
  const Real special[] = {0, -Real(0), 1, -1, INFINITY, -INFINITY, NAN, 700, -700};
  std::copy(std::begin(special), std::end(special), values.begin());
  return values;
}

/// Numbers that are NaN have many bit patterns. All of them count as equal.
template <class Real>
bool SameBits(Real a, Real b) {
  return (std::isnan(a) && std::isnan(b)) || std::memcmp(&a, &b, sizeof a) == 0;
}

TYPED_TEST(KernelsTest, AllInstructionSetsGiveTheBitsOfScalarArithmetic) {
  const auto a = Values<TypeParam>(1), b = Values<TypeParam>(2), c = Values<TypeParam>(3);
  const TypeParam uniforms[] = {TypeParam(1.25)};
  for (const Kernels<TypeParam>& kernels : AvailableKernels<TypeParam>()) {
    for (const Operation operation : kAll) {
      for (const uint16_t second : {uint16_t{1}, kUniform}) {
        std::vector<std::vector<TypeParam>> memory{a, b, c, std::vector<TypeParam>(kBlock)};
        std::vector<TypeParam*> registers;
        for (auto& block : memory) {
          block.resize(kBlock + kPadding);
          registers.push_back(block.data());
        }
        const bool unary = operation >= Operation::kNegate && operation <= Operation::kAbs;
        const bool function = operation == Operation::kFloor || operation == Operation::kNot ||
                              (operation >= Operation::kExp && operation <= Operation::kAtan) ||
                              operation == Operation::kTanh;
        Instruction step{operation, 3, 0, second, 2};
        if (unary || function) step.b = 0xffff;
        kernels.run({&step, 1}, registers.data(), uniforms, kBlock);
        for (size_t i = 0; i < kBlock; ++i) {
          const TypeParam right = second == kUniform ? uniforms[0] : b[i];
          const TypeParam expected = ComputeIn<TypeParam>(operation, a[i], right, c[i]);
          ASSERT_TRUE(SameBits(memory[3][i], expected))
              << kernels.name << ", operation " << static_cast<int>(operation) << " of " << a[i]
              << " and " << right << ": " << memory[3][i] << ", expected " << expected;
        }
      }
    }
  }
}

TYPED_TEST(KernelsTest, SumsAndRowsAreTheSameForAllSets) {
  const auto values = Values<TypeParam>(7);
  std::vector<TypeParam> finite(values.begin() + 9, values.end());
  std::vector<TypeParam> sums;
  for (const Kernels<TypeParam>& kernels : AvailableKernels<TypeParam>()) {
    for (const size_t count : {size_t{1}, size_t{7}, size_t{16}, size_t{45}}) {
      std::vector<TypeParam> copy = finite;
      copy.resize(kBlock + kPadding);
      sums.push_back(kernels.sum(copy.data(), count));
      std::vector<TypeParam> rows(3 * count + 1, TypeParam(2)), x(kBlock), y(kBlock), z(kBlock);
      kernels.add3(rows.data(), count, finite.data(), finite.data() + 1, finite.data() + 2);
      kernels.split3(rows.data(), count, x.data(), y.data(), z.data());
      for (size_t i = 0; i < count; ++i) {
        EXPECT_EQ(x[i], TypeParam(2) + finite[i]);
        EXPECT_EQ(y[i], TypeParam(2) + finite[i + 1]);
        EXPECT_EQ(z[i], TypeParam(2) + finite[i + 2]);
      }
      EXPECT_EQ(rows.back(), TypeParam(2)) << "wrote behind the last row";
      EXPECT_TRUE(kernels.finite(finite.data(), count));
      EXPECT_FALSE(kernels.finite(values.data(), kBlock));
    }
  }
  for (size_t i = 4; i < sums.size(); ++i) EXPECT_EQ(sums[i], sums[i % 4]);
}

TEST(ElementaryTest, FunctionsAreAccurate) {
  std::mt19937_64 random(5);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
  };
  struct Function {
    Operation operation;
    double low, high;
    long double (*exact)(long double);
    double tolerance;  // in units of the last place
  };
  const Function functions[] = {
      {Operation::kExp, -700, 700, std::exp, 2},    {Operation::kLn, 1e-300, 1e300, std::log, 2},
      {Operation::kLn, 0.5, 2, std::log, 2},        {Operation::kSin, -1e4, 1e4, std::sin, 4},
      {Operation::kCos, -1e4, 1e4, std::cos, 4},    {Operation::kTan, -1.5, 1.5, std::tan, 6},
      {Operation::kAsin, -1, 1, std::asin, 6},      {Operation::kAcos, -1, 1, std::acos, 6},
      {Operation::kAtan, -50, 50, std::atan, 2},    {Operation::kTanh, -3, 3, std::tanh, 16},
      {Operation::kTanh, -0.15, 0.15, std::tanh, 4}};
  for (const Function& function : functions) {
    double worst = 0;
    for (int i = 0; i < 20000; ++i) {
      const double x = draw(function.low, function.high);
      const long double expected = function.exact(x);
      const double found = Elementary(function.operation, x, 0);
      const double place = std::nextafter(std::abs(static_cast<double>(expected)), INFINITY) -
                           std::abs(static_cast<double>(expected));
      // The error near a zero of sine and cosine comes from the reduction of the argument.
      const double floor =
          function.operation == Operation::kSin || function.operation == Operation::kCos ? 0x1p-56
                                                                                         : 0;
      worst =
          std::max(worst, static_cast<double>(std::abs(found - expected)) / std::max(place, floor));
    }
    EXPECT_LE(worst, function.tolerance) << static_cast<int>(function.operation);
  }
  EXPECT_EQ(Elementary(Operation::kAtan2, -1, -1), -3 * std::atan(1.0));
  EXPECT_NEAR(Elementary(Operation::kPower, 2, 0.5), std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(Elementary(Operation::kPower, -2, 3), -8, 1e-14);
  EXPECT_TRUE(std::isnan(Elementary(Operation::kPower, -2, 0.5)));
}

}  // namespace
}  // namespace vesper::text
