// SPDX-License-Identifier: Apache-2.0
// A property provider that the client implements: the engine queries it for arrays.
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
  /// An additional check of a property's arrays; throws to refuse them.
  using Check = std::function<void(uint32_t property, const Arrays& arrays)>;

  /// Copies `callbacks`; throws INVALID_ARGUMENT if one is missing.
  CustomProvider(const vesper_provider_callbacks& callbacks, const Prototype& prototype);

  /// Queries all properties if the provider's version has changed, and binds the answers. Throws if
  /// the provider fails or an answer is invalid. In this case it binds nothing, and the next call
  /// queries again.
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
  std::vector<Answer> answers_;  // answers in prototype order
  bool asked_ = false;
  uint64_t version_ = 0;
};

}  // namespace vesper
