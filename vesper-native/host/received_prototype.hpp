// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "message.hpp"
#include "vesper/engine.h"

namespace vesper::host {

/// A prototype that was read from a message, with the strings to which it points.
class ReceivedPrototype {
 public:
  explicit ReceivedPrototype(Reader& request) {
    prototype_.struct_size = sizeof prototype_;
    prototype_.name = Keep(request.Text());
    prototype_.real_type = request.Value<uint32_t>();
    prototype_.time_unit = request.Unit();
    properties_.resize(request.Value<uint32_t>());
    for (vesper_property_descriptor& property : properties_) property = Descriptor(request);
    prototype_.property_count = static_cast<uint32_t>(properties_.size());
    prototype_.properties = properties_.data();
  }
  ReceivedPrototype(const ReceivedPrototype&) = delete;
  ReceivedPrototype& operator=(const ReceivedPrototype&) = delete;

  const vesper_prototype& get() const { return prototype_; }
  const std::vector<vesper_property_descriptor>& properties() const { return properties_; }

 private:
  vesper_property_descriptor Descriptor(Reader& request) {
    vesper_property_descriptor property{};
    property.struct_size = sizeof property;
    property.name = Keep(request.Text());
    property.kind = Keep(request.Text());
    property.scalar_type = request.Value<uint32_t>();
    property.components = request.Value<uint32_t>();
    property.law_access = request.Value<uint32_t>();
    property.unit = request.Unit();
    property.refers_to = KeepUnlessEmpty(request.Text());
    property.initial_from = KeepUnlessEmpty(request.Text());
    property.has_minimum = request.Value<uint32_t>();
    property.minimum = request.Value<double>();
    property.doc = Keep(request.Text());
    return property;
  }
  const char* Keep(std::string text) { return strings_.emplace_back(std::move(text)).c_str(); }
  const char* KeepUnlessEmpty(std::string text) {
    return text.empty() ? nullptr : Keep(std::move(text));
  }

  std::deque<std::string> strings_;
  std::vector<vesper_property_descriptor> properties_;
  vesper_prototype prototype_{};
};

}  // namespace vesper::host
