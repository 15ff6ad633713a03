// SPDX-License-Identifier: Apache-2.0
// A random world for laws of any kind, with a column or a field for every property of a standard
// prototype and of a law.
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
  /// Creates a column or an analytic field for every property of the standard prototype, and for
  /// properties that only the laws use or that their library `brings`. The tables of the laws must
  /// stay loaded. Every kind has `rows` rows, except `world`, which has one (none if `rows` is 0).
  /// References point to neighbouring rows, which are close to each other. Masses and similar
  /// values are above zero.
  World(vesper_scalar_type real_type, const std::vector<const vesper_law_desc*>& laws,
        std::span<const vesper_field_desc> brings, uint64_t rows, uint32_t seed);

  World(World&&) = default;
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  AnyColumn& operator[](const std::string& name);
  const AnyColumn& operator[](const std::string& name) const;
  std::vector<AnyColumn>& columns() { return columns_; }
  /// Returns the column of a property that a law uses. A SCRATCH property may have the name of
  /// another property.
  AnyColumn& ColumnOf(const vesper_property& used);

  /// Sets every value of a property to zero.
  void Clear(const std::string& name);
  void Translate(const Vec3<double>& by);
  /// Rotates vectors, orientations and fields about the origin.
  void Rotate(const Quaternion& by);

  /// Returns the columns and fields that a law uses, in the order of its uses. The results point
  /// into this object.
  std::vector<vesper_property> PropertiesFor(const vesper_law_desc& law);
  /// Creates an engine with one library. Its prototype contains the world's fields for FIELD
  /// properties that the library does not provide. The world must keep its address from now on.
  PhysicsEngine MakeEngine(const std::string& library, uint32_t threads = 1, bool validate = true);
  /// Loads a library of any form into an engine of this world.
  vesper_library_id Load(PhysicsEngine& engine, const std::string& library,
                         const std::vector<ParameterValue>& parameters = {}) const;

 private:
  vesper_property PropertyFor(const vesper_property_use& use);
  void Place(AnyColumn& column, const std::function<double(double, double)>& draw);
  void Fill(AnyColumn& column, const std::function<double(double, double)>& draw);

  vesper_prototype prototype_;
  std::vector<vesper_property_descriptor> descriptors_;
  std::vector<AnyColumn> columns_;
  std::vector<AnalyticField> fields_;
  std::set<std::string> brought_;  // fields that the library provides to an engine
};

}  // namespace vesper
