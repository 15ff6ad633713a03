// SPDX-License-Identifier: Apache-2.0
#include "converting_runner.hpp"

#include <cinttypes>
#include <cstring>
#include <utility>

#include "aligned_buffer.hpp"
#include "failure.hpp"
#include "field.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

/// A column of a use that is converted to the law's unit, with its values before the law ran. A
/// FIELD property has a converted field instead.
struct Converted {
  std::unique_ptr<ConvertedField> function;
  vesper_field field{};
  AlignedBuffer values;
  AlignedBuffer before;
};

uint64_t ValueCount(const vesper_property& property) {
  return property.row_count * property.components;
}

class ConvertingRunner final : public LawRunner {
 public:
  ConvertingRunner(Law& law, std::unique_ptr<LawRunner> inner, std::vector<UnitRatio> ratios)
      : law_(law), inner_(std::move(inner)), ratios_(std::move(ratios)), columns_(ratios_.size()) {}

  void Bind(const Targets& targets) override {
    targets_ = &targets;
    seen_ = targets;
    for (size_t i = 0; i < targets.size(); ++i) {
      if (IsField(targets[i].scalar_type)) ConvertField(i);
      if (!IsConverted(i)) continue;
      const size_t size = ValueCount(targets[i]) * ScalarSize(targets[i].scalar_type);
      columns_[i].values.Resize(size);
      if (targets[i].access == VESPER_READ_WRITE) columns_[i].before.Resize(size);
      seen_[i].data = columns_[i].values.data();
    }
    CopyIn();
    inner_->Bind(seen_);
  }

  void Advance(const vesper_step& step) override {
    CopyIn();
    inner_->Advance(step);
    for (size_t i = 0; i < seen_.size(); ++i) {
      if (seen_[i].access != VESPER_READ && !law_.Defers(i)) CopyOut(i);
    }
  }

  void Synchronize(uint32_t use) override {
    CopyIn();
    inner_->Synchronize(use);
    CopyOut(use);
  }

  double PotentialEnergy() override {
    CopyIn();
    return inner_->PotentialEnergy();
  }

 private:
  bool IsConverted(size_t i) const { return !ratios_[i].IsOne() && (*targets_)[i].row_count > 0; }

  void ConvertField(size_t i) {
    if (ratios_[i].IsOne() || seen_[i].data == nullptr) return;
    const auto& source = *static_cast<const vesper_field*>(seen_[i].data);
    columns_[i].function =
        std::make_unique<ConvertedField>(source, ratios_[i], ValuesPerPlace(law_.desc().uses[i]));
    columns_[i].field = columns_[i].function->field();
    seen_[i].data = &columns_[i].field;
  }

  void CopyIn() {
    for (size_t i = 0; i < seen_.size(); ++i) {
      if (!IsConverted(i) || (seen_[i].access & VESPER_READ) == 0) continue;
      const uint64_t count = ValueCount(seen_[i]);
      Convert(seen_[i].scalar_type, seen_[i].data, (*targets_)[i].data, ratios_[i], count);
      if (seen_[i].access != VESPER_READ_WRITE) continue;
      std::memcpy(columns_[i].before.data(), seen_[i].data, columns_[i].before.size());
    }
  }

  void CopyOut(size_t i) {
    if (!IsConverted(i)) return;
    const vesper_property& target = (*targets_)[i];
    const uint64_t count = ValueCount(target);
    const UnitRatio back = ratios_[i].Inverse();
    if (seen_[i].access == VESPER_READ_WRITE) {
      // Only changed values are converted back, because two conversions could change the bits of a
      // value by rounding.
      ConvertChanged(target.scalar_type, target.data, seen_[i].data, columns_[i].before.data(),
                     back, count);
    } else {
      Convert(target.scalar_type, target.data, seen_[i].data, back, count);
    }
    CheckFinite(target);
  }

  void CheckFinite(const vesper_property& target) const {
    const uint64_t bad = FindNonFinite(target.scalar_type, target.data, ValueCount(target));
    if (bad == kNotFound) return;
    const uint64_t row = bad / target.components;
    throw Failure(VESPER_LAW_MISBEHAVED,
                  "%s: property %s, row %" PRIu64
                  ": what it wrote overflows in the prototype's unit",
                  law_.label().c_str(), target.name, row)
        .Property(target.name)
        .Row(row);
  }

  Law& law_;
  std::unique_ptr<LawRunner> inner_;
  std::vector<UnitRatio> ratios_;
  std::vector<Converted> columns_;
  const Targets* targets_ = nullptr;
  Targets seen_;
};

}  // namespace

std::unique_ptr<LawRunner> MakeConvertingRunner(Law& law, std::unique_ptr<LawRunner> inner,
                                                std::vector<UnitRatio> ratios) {
  return std::make_unique<ConvertingRunner>(law, std::move(inner), std::move(ratios));
}

}  // namespace vesper
