// SPDX-License-Identifier: Apache-2.0
// Friction, restitution and resistance to rolling and spinning, by the substances of two bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "vesper/law.hpp"

namespace vesper::rigid {

/** Values in worlds with substances. The value 0 of a column means that the value is not set. */
namespace own {

// A set value below this one counts as 0. World files write an explicit 0 as such a value.
inline constexpr double kLeast = 1e-9;

/** Returns a set value, or nothing if it is not set. */
inline std::optional<double> Set(double value) {
  if (value == 0) return std::nullopt;
  return value < kLeast ? 0 : value;
}

}  // namespace own

/** The columns of substances, and the values that they contain. */
template <class Real>
class Substances {
 public:
  /** The values of a body, a substance or a pair of substances, as far as they are set. */
  struct Values {
    std::optional<double> friction, restitution;  // [1]
    std::optional<double> rolling, spinning;      // lever arms [m]
  };

  /** Return the columns in two groups, whose places in the order of the law's columns differ. */
  auto Properties() { return std::tie(substance_, pair_, friction_, restitution_); }
  auto LastProperties() { return std::tie(rolling_, spinning_); }

  /** Returns whether the world has substances. Otherwise the other functions must not be called. */
  bool present() const { return substance_.present(); }
  /** Return whether substances of the world have a resistance to rolling, or to spinning. The value
   *  0 of the column of a body then means that the value is not set. */
  bool HasRolling() const { return present() && rolling_.present(); }
  bool HasSpinning() const { return present() && spinning_.present(); }

  /** Reads the rows of substances and pairs; call once in each step. */
  void Gather() {
    rows_.clear();
    if (!pair_.present()) return;
    for (uint64_t i = 0; i < pair_.size(); ++i) {
      const auto [a, b] = pair_[i];
      const auto value = [&](const auto& column) {
        return column.present() ? double{column[i]} : 0;
      };
      const double friction = value(friction_), restitution = value(restitution_);
      const double rolling = value(rolling_), spinning = value(spinning_);
      if (!std::isfinite(friction + restitution + rolling + spinning)) {
        throw std::runtime_error("substancePair row " + std::to_string(i) +
                                 " has values that are not finite");
      }
      rows_.push_back({{std::min(a, b), std::max(a, b)},
                       {own::Set(friction), own::Set(std::min(1.0, restitution)), own::Set(rolling),
                        own::Set(spinning)}});
    }
    std::stable_sort(rows_.begin(), rows_.end(),
                     [](const Row& x, const Row& y) { return x.codes < y.codes; });
  }

  /** Returns a number that differs for different values of substances. */
  template <class Digest>
  uint64_t DigestOfRows() const {
    Digest digest;
    for (const Row& row : rows_) {
      digest.Add(uint64_t(uint32_t(row.codes.first))).Add(uint64_t(uint32_t(row.codes.second)));
      digest.Add(row.values.friction.value_or(-1)).Add(row.values.restitution.value_or(-1));
      if (HasRolling()) digest.Add(row.values.rolling.value_or(-1));
      if (HasSpinning()) digest.Add(row.values.spinning.value_or(-1));
    }
    return digest.value();
  }

  /** Returns the code of the substance of a shape; 0 for none, and for scenery. */
  int32_t CodeOf(uint32_t shape) const { return shape < substance_.size() ? substance_[shape] : 0; }
  /** Returns the values of a substance with any other substance. */
  const Values& Of(int32_t code) const { return Of(0, code); }
  /** Returns the values of a pair of substances. */
  const Values& Of(int32_t a, int32_t b) const {
    static constexpr Values kNone{};
    const std::pair<int32_t, int32_t> codes{std::min(a, b), std::max(a, b)};
    const auto found =
        std::lower_bound(rows_.begin(), rows_.end(), codes,
                         [](const Row& row, const auto& wanted) { return row.codes < wanted; });
    return codes.second != 0 && found != rows_.end() && found->codes == codes ? found->values
                                                                              : kNone;
  }

 private:
  struct Row {
    std::pair<int32_t, int32_t> codes;  // the smaller code first; 0: any substance
    Values values;
  };

  OptionalRead<int32_t> substance_{"substance", "body", units::one};
  OptionalRead<std::array<int32_t, 2>> pair_{"substances", "substancePair", units::one};
  OptionalRead<Real> friction_{"pairFriction", "substancePair", units::one};
  OptionalRead<Real> restitution_{"pairRestitution", "substancePair", units::one};
  OptionalRead<Real> rolling_{"pairRollingFriction", "substancePair", units::metre};
  OptionalRead<Real> spinning_{"pairSpinFriction", "substancePair", units::metre};
  std::vector<Row> rows_;  // in the order of their codes
};

/** The values of a contact. */
struct Touching {
  double friction, restitution;  // [1]
  double rolling, spinning;      // lever arms of the torques against rolling and spinning [m]
};

/** Returns the values of the contact of two shapes of a world with substances. A value of a body
 *  itself precedes the value of the pair of substances. The value of this pair precedes those of
 *  the two substances, and these precede the parameters of the law.
 *  @param of_body returns the own values of a shape, as far as they are set */
template <class Real, class OfBody>
Touching TouchOf(const Substances<Real>& substances, uint32_t a, uint32_t b,
                 const Touching& parameters, OfBody&& of_body) {
  using Values = typename Substances<Real>::Values;
  const int32_t code_a = substances.CodeOf(a), code_b = substances.CodeOf(b);
  const Values own_a = of_body(a), own_b = of_body(b);
  const Values &of_a = substances.Of(code_a), &of_b = substances.Of(code_b);
  const Values& pair = substances.Of(code_a, code_b);
  const bool is_pair = code_a != 0 && code_b != 0;
  const auto value = [&](std::optional<double> Values::* member, double parameter, auto&& combine) {
    const std::optional<double>&first = own_a.*member, &second = own_b.*member;
    if (is_pair && pair.*member && !first && !second) return *(pair.*member);
    return double{combine(first.value_or((of_a.*member).value_or(parameter)),
                          second.value_or((of_b.*member).value_or(parameter)))};
  };
  const auto mean = [](double x, double y) { return std::sqrt(x * y); };
  const auto larger = [](double x, double y) { return std::max(x, y); };
  return {value(&Values::friction, parameters.friction, mean),
          value(&Values::restitution, parameters.restitution, larger),
          value(&Values::rolling, parameters.rolling, larger),
          value(&Values::spinning, parameters.spinning, larger)};
}

}  // namespace vesper::rigid
