// SPDX-License-Identifier: Apache-2.0
// A random world with a column or a field for every property of a standard prototype and of a law,
// for laws of any kind.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "vesper/kit/column.hpp"
#include "vesper/kit/field.hpp"
#include "vesper/kit/quaternion.hpp"
#include "vesper/law.hpp"
#include "vesper/vesper.hpp"

namespace vesper {

class World {
 public:
  /// A column, or an analytic field, for every property of the standard prototype, and for those
  /// that only the laws know or that their library `brings`; their tables must stay loaded. `rows`
  /// of every kind but `world`, which has one (none if `rows` is 0). References name neighbouring
  /// rows, which lie near each other; masses and the like are above zero.
  World(vesper_scalar_type real_type, const std::vector<const vesper_law_desc*>& laws,
        std::span<const vesper_field_desc> brings, uint64_t rows, uint32_t seed);

  World(World&&) = default;
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  AnyColumn& operator[](const std::string& name);
  const AnyColumn& operator[](const std::string& name) const;
  std::vector<AnyColumn>& columns() { return columns_; }

  /// Sets every value of a property to zero.
  void Clear(const std::string& name);
  void Translate(const Vec3<double>& by);
  /// Turns vectors, orientations and fields about the origin.
  void Rotate(const Quaternion& by);

  /// The columns and fields that a law uses, in its order; borrowed, as all its values.
  std::vector<vesper_property> PropertiesFor(const vesper_law_desc& law);
  /// Loads one library, in a prototype with fields of the world for those that it does not bring.
  /// The world must stay in place from now on.
  PhysicsEngine MakeEngine(const std::string& library, uint32_t threads = 1, bool validate = true);

 private:
  vesper_property PropertyFor(const vesper_property_use& use);
  void Place(AnyColumn& column, const std::function<double(double, double)>& draw);
  void Fill(AnyColumn& column, const std::function<double(double, double)>& draw);

  vesper_prototype prototype_;
  std::vector<vesper_property_descriptor> descriptors_;
  std::vector<AnyColumn> columns_;
  std::vector<AnalyticField> fields_;
  std::set<std::string> brought_;  // fields that the library gives to an engine
};

}  // namespace vesper
