// SPDX-License-Identifier: Apache-2.0
// A field as one law reads it.
#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <string>

#include "failure.hpp"
#include "field.hpp"

namespace vesper {

/// Remembers the place at which a field gave no value that the law can use. If the law then fails,
/// the library that provides the field is the cause. Several threads may evaluate the field.
class WatchedField {
 public:
  WatchedField() : field_{sizeof(vesper_field), 0, this, Evaluate} {}
  WatchedField(const WatchedField&) = delete;
  WatchedField& operator=(const WatchedField&) = delete;

  /// Sets the field that the law reads. Values of the magnitude `limit` or more are wrong.
  void Read(const vesper_field& source, uint32_t components, double limit);
  /// Returns the field for the law; it has the same address for the life of this object.
  vesper_field* field() { return &field_; }
  /// Forgets wrong values of earlier calls of the law. Called while the law does not run.
  void BeginCall() { wrong_ = false; }
  /// Returns the failure of the library that provides the field `name`, if the field gave a wrong
  /// value since BeginCall. Empty if a client provides the field.
  std::optional<Failure> Blamed(const char* name, const std::string& reader) const;

 private:
  static void Evaluate(void* user, uint64_t count, const double* at, double* out);
  void Note(const double* at, double value);

  vesper_field field_;
  vesper_field source_{};
  uint32_t components_ = 1;
  double limit_ = 0;
  std::atomic_flag noting_;
  bool wrong_ = false;
  std::array<double, 3> place_{};  // the first of all wrong places in the order of x, y and z, so
                                   // that it does not depend on the number of threads
  double value_ = 0;
};

}  // namespace vesper
