// SPDX-License-Identifier: Apache-2.0
#include "watched_field.hpp"

#include <algorithm>
#include <cmath>

#include "foreign_call.hpp"

namespace vesper {

void WatchedField::Read(const vesper_field& source, uint32_t components, double limit) {
  source_ = source;
  components_ = components;
  limit_ = limit;
  wrong_ = false;
}

void WatchedField::Evaluate(void* user, uint64_t count, const double* at, double* out) {
  auto& self = *static_cast<WatchedField*>(user);
  self.source_.evaluate(self.source_.user, count, at, out);
  const uint64_t values = count * self.components_;
  bool right = true;
  for (uint64_t i = 0; i < values; ++i) right &= std::abs(out[i]) < self.limit_;
  if (right) return;
  for (uint64_t i = 0; i < values; ++i) {
    if (!(std::abs(out[i]) < self.limit_)) self.Note(at + 3 * (i / self.components_), out[i]);
  }
}

void WatchedField::Note(const double* at, double value) {
  const std::array<double, 3> place{at[0], at[1], at[2]};
  if (!std::ranges::all_of(place, [](double x) { return std::isfinite(x); })) return;
  while (noting_.test_and_set(std::memory_order_acquire)) {
  }
  if (!wrong_ || place < place_) {
    wrong_ = true;
    place_ = place;
    value_ = value;
  }
  noting_.clear(std::memory_order_release);
}

std::optional<Failure> WatchedField::Blamed(const char* name, const std::string& reader) const {
  if (!wrong_) return std::nullopt;
  const FieldProvider* provider = ConvertedField::ProviderOf(source_);
  if (provider == nullptr) return std::nullopt;
  vesper_error error = BlankError();
  if (provider->desc->explain != nullptr) {
    CallForeignQuietly([&] { provider->desc->explain(provider->suite, place_.data(), &error); });
    Sanitize(error);
  }
  const std::string what = error.message;
  Failure failure =
      what.empty()
          ? Failure(VESPER_LAW_FAILED,
                    "library %s: field %s: found %g at (%g, %g, %g) m, where %s reads it; "
                    "expected a finite number",
                    provider->name.c_str(), name, value_, place_[0], place_[1], place_[2],
                    reader.c_str())
          : Failure(VESPER_LAW_FAILED, "%s, where %s reads it", what.c_str(), reader.c_str());
  failure.Library(provider->library).Property(name);
  if (error.law_index < provider->laws) failure.Law(error.law_index);
  return failure;
}

}  // namespace vesper
