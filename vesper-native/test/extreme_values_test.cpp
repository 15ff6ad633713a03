// SPDX-License-Identifier: Apache-2.0
// Tests numbers that a law writes to any row of any property: those that are refused, and those
// that are kept to the bit.
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "test_kit.hpp"

namespace vesper::test {
namespace {

constexpr size_t kRows = 10'000;

/// A property that the law `poke` writes, in the order of its uses.
struct Column {
  const char* name;
  uint32_t components;
  std::vector<double>* values;
};

/// A value that the law `poke` writes, in the order of its table.
struct Value {
  double value;
  bool refused;
};

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Value kValues[] = {{std::nan(""), true}, {kInfinity, true}, {-kInfinity, true},
                         {0x1p333, true},      {1e38, false},     {-0.0, false},
                         {0x1p-1074, false}};

/// Number of rows from one tested row to the next. It is 1 if the environment variable
/// VESPER_EVERY_ROW is set.
size_t Stride() { return std::getenv("VESPER_EVERY_ROW") != nullptr ? 1 : 211; }

class ExtremeValuesTest : public BothModes {
 protected:
  ExtremeValuesTest() {
    engine_.AddBodies(bodies_);
    EXPECT_OK(engine_.Add("angularVelocity", spin_, 3));
    EXPECT_OK(engine_.Add("gravity", place_, 3));
    engine_.Load("poke");
  }

  /// Advances a step in which the law writes a value, and checks the refusal or the number.
  void Poke(const Column& column, size_t property, size_t row, size_t value) {
    double& number = (*column.values)[column.components * row + row % column.components];
    const double before = number;
    place_ = {static_cast<double>(property), static_cast<double>(row), static_cast<double>(value)};
    const vesper_error error = engine_.Advance(1, 1);
    if (kValues[value].refused) {
      EXPECT_REFUSED(LAW_MISBEHAVED, "law poke: property ", error);
      EXPECT_STREQ(error.property, column.name);
      EXPECT_EQ(error.row, row);
      EXPECT_OK(Try([&](vesper_error* e) { return vesper_engine_clear_fault(engine_.get(), e); }));
    } else {
      EXPECT_OK(error);
      EXPECT_EQ(std::bit_cast<uint64_t>(number), std::bit_cast<uint64_t>(kValues[value].value));
      ++steps_;
    }
    number = before;
  }

  Bodies bodies_{kRows};
  std::vector<double> spin_ = std::vector<double>(3 * kRows);
  std::vector<double> place_ = std::vector<double>(3);
  TestEngine engine_{{.validate = GetParam(), .limit_values = true}};
  uint64_t steps_ = 0;
};
IN_BOTH_MODES(ExtremeValuesTest);

/// The client restores the number after a refusal, as the adapter restores all columns.
TEST_P(ExtremeValuesTest, EachIsRefusedByPropertyAndRowOrKeptToTheBit) {
  const Column columns[] = {{"position", 3, &bodies_.position},
                            {"velocity", 3, &bodies_.velocity},
                            {"orientation", 4, &bodies_.orientation},
                            {"angularVelocity", 3, &spin_},
                            {"acceleration", 3, &bodies_.acceleration}};
  for (size_t property = 0; property < std::size(columns); ++property) {
    for (size_t row = property; row < kRows && !HasFailure(); row += Stride()) {
      for (size_t value = 0; value < std::size(kValues); ++value) {
        SCOPED_TRACE(std::string(columns[property].name) + ", row " + std::to_string(row) +
                     ", value " + std::to_string(kValues[value].value));
        Poke(columns[property], property, row, value);
      }
    }
  }
  EXPECT_EQ(vesper_engine_step_count(engine_.get()), steps_) << "a refused step does not count";
}

}  // namespace
}  // namespace vesper::test
