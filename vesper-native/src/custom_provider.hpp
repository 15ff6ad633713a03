// SPDX-License-Identifier: Apache-2.0
// A property provider of the client's own: arrays are asked for, not registered.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "columns.hpp"
#include "prototype.hpp"
#include "vesper/engine.h"

namespace vesper {

class CustomProvider {
 public:
  /// Refuses a further check of a property's arrays by throwing.
  using Check = std::function<void(uint32_t property, const Arrays& arrays)>;

  /// Copies `callbacks`; throws INVALID_ARGUMENT if one is missing.
  CustomProvider(const vesper_provider_callbacks& callbacks, const Prototype& prototype);

  /// Asks for all properties if the provider's version changed since it was asked, and binds the
  /// answers. Throws what the provider answers, or what is wrong with it; then nothing is bound
  /// anew, and the next call asks again.
  void Refresh(Columns& columns, const Check& check);

 private:
  struct Answer {
    bool known;
    Arrays arrays;
    uint64_t version;
    vesper_field field;
  };

  Answer Ask(const PropertySpec& property) const;
  static void Bind(Columns& columns, uint32_t property, const Answer& before, const Answer& now);

  vesper_provider_callbacks callbacks_;
  const Prototype& prototype_;
  std::vector<Answer> answers_;  // in prototype order
  bool asked_ = false;
  uint64_t version_ = 0;
};

}  // namespace vesper
