// SPDX-License-Identifier: Apache-2.0
#include "vesper/kit/world.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>

#include "vesper/kit/law_file.hpp"
#include "vesper/kit/test_prototype.hpp"

namespace vesper {
namespace {

const std::string kRadius = "radius";

/// Returns true for columns of places in the world.
bool IsPlace(const std::string& name) { return name == "position" || name == "sceneryPosition"; }
/// Returns true for columns of rotations.
bool IsRotation(const std::string& name) {
  return name == "orientation" || name == "sceneryOrientation";
}
/// Returns true for columns of lengths of bodies.
bool IsSize(const std::string& name) {
  return name == kRadius || name == "size" || name == "scenerySize";
}

// Codes of shapes that the columns of worlds contain.
constexpr double kShapes = 7;

/// Returns half the side [m] of the box of the bodies, with about one body per cubic metre.
double ReachOf(uint64_t bodies) {
  return std::max(2.0, std::cbrt(static_cast<double>(bodies)) / 2);
}

void Normalise(AnyColumn& column, uint64_t row) {
  const uint32_t n = column.descriptor().components;
  double square = 0;
  for (uint64_t i = row * n; i < (row + 1) * n; ++i) square += column.Get(i) * column.Get(i);
  for (uint64_t i = row * n; i < (row + 1) * n; ++i) {
    column.Set(i, column.Get(i) / std::sqrt(square));
  }
}

/// Returns true for a SCRATCH property. An engine allocates the memory of such a property. A law
/// that runs without an engine gets a column instead.
bool IsScratch(const vesper_property_descriptor& property) {
  return property.law_access == VESPER_SCRATCH;
}

bool IsField(const vesper_property_descriptor& property) {
  return property.scalar_type == VESPER_FIELD;
}

/// Returns true for the property that a law uses by this name. A column of the law's own may have
/// the name of a property of the prototype.
bool IsUsed(const vesper_property_descriptor& property, const std::string& name,
            const std::string& kind, vesper_access access) {
  return property.name == name && property.kind == kind &&
         IsScratch(property) == ((access & VESPER_SCRATCH) != 0);
}

/// Returns the properties of the prototype, then those that only the library declares. SCRATCH
/// properties are last.
std::vector<vesper_property_descriptor> DescriptorsFor(
    const vesper_prototype& prototype, const std::vector<const vesper_law_desc*>& laws,
    std::span<const vesper_field_desc> brings) {
  std::vector<vesper_property_descriptor> all(prototype.properties,
                                              prototype.properties + prototype.property_count);
  for (const vesper_law_desc* law : laws) {
    for (const auto& use : std::span(law->uses, law->use_count)) {
      const auto known = std::ranges::find_if(
          all, [&](const auto& each) { return IsUsed(each, use.name, use.kind, use.access); });
      if (known == all.end()) {
        all.push_back({sizeof(vesper_property_descriptor), use.scalar_type, use.name, use.kind,
                       use.components, use.access, use.unit, nullptr, nullptr,
                       "Declared by the law.", 0, 0, 0});
      } else if (known >= all.begin() + prototype.property_count) {
        known->law_access |= use.access;
      }
    }
  }
  for (const vesper_field_desc& field : brings) {
    const auto named = [&](const auto& property) {
      return property.name == std::string(field.name);
    };
    if (std::ranges::any_of(all, named)) continue;
    all.push_back({sizeof(vesper_property_descriptor), VESPER_FIELD, field.name, "world",
                   field.components, VESPER_READ, field.unit, nullptr, nullptr, field.doc, 0, 0,
                   0});
  }
  std::ranges::stable_partition(all, std::not_fn(IsScratch));
  return all;
}

/// Rotates every row of a column of quaternions.
void RotateRows(AnyColumn& column, const Quaternion& by) {
  for (uint64_t row = 0; row < column.rows(); ++row) {
    const Quaternion before{{column.Get(4 * row), column.Get(4 * row + 1), column.Get(4 * row + 2)},
                            column.Get(4 * row + 3)};
    const Quaternion after = by * before;
    column.Set(4 * row, after.v.x);
    column.Set(4 * row + 1, after.v.y);
    column.Set(4 * row + 2, after.v.z);
    column.Set(4 * row + 3, after.w);
  }
}

}  // namespace

World::World(vesper_scalar_type real_type, const std::vector<const vesper_law_desc*>& laws,
             std::span<const vesper_field_desc> brings, uint64_t rows, uint32_t seed)
    : prototype_(TestPrototype(real_type)), descriptors_(DescriptorsFor(prototype_, laws, brings)) {
  prototype_.properties = descriptors_.data();
  prototype_.property_count =
      static_cast<uint32_t>(std::ranges::count_if(descriptors_, std::not_fn(IsScratch)));
  for (const vesper_field_desc& field : brings) brought_.insert(field.name);
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (const vesper_property_descriptor& property : descriptors_) {
    if (IsField(property)) {
      fields_.emplace_back(property);
      continue;
    }
    const bool single = property.kind == std::string("world");
    columns_.emplace_back(property, single ? std::min<uint64_t>(rows, 1) : rows);
    Fill(columns_.back(), draw);
  }
}

// Each body is within a metre of the previous one in every direction, so distances between
// neighbouring rows are similar to lengths and radii.
void World::Place(AnyColumn& column, const std::function<double(double, double)>& draw) {
  const double reach = ReachOf(column.rows());
  Vec3<double> at{draw(-reach, reach), draw(-reach, reach), draw(-reach, reach)};
  const auto next = [&](double x) {
    const double to = x + draw(-1, 1);
    return std::abs(to) > reach ? 2 * x - to : to;
  };
  for (uint64_t row = 0; row < column.rows(); ++row) {
    column.SetVector(row, at);
    at = {next(at.x), next(at.y), next(at.z)};
  }
}

void World::Fill(AnyColumn& column, const std::function<double(double, double)>& draw) {
  const vesper_property_descriptor& property = column.descriptor();
  // These columns get no values, because the engine computes sums, and scratch starts at zero.
  if ((property.law_access & (VESPER_ACCUMULATE | VESPER_SCRATCH)) != 0) return;
  const std::string name = property.name;
  if (IsPlace(name)) return Place(column, draw);
  const bool is_size = IsSize(name);  // small, so that few bodies touch each other
  const bool is_shape = name == "shape" || name == "sceneryShape";
  const bool is_none = name == "carrier" || name == "sceneryCarrier" || name == "meshForm" ||
                       name == "sceneryMeshForm";
  if (name == "partOfBody") return;  // nothing is attached
  const bool is_vector = column.is_vector();
  const bool is_rotation = IsRotation(name);
  for (uint64_t row = 0; row < column.rows(); ++row) {
    // Neighbouring rows are used, so that the rows of one reference differ.
    auto reference = static_cast<uint64_t>(draw(0, static_cast<double>(column.rows())));
    for (uint32_t c = 0; c < property.components; ++c) {
      const uint64_t value = row * property.components + c;
      if (property.refers_to != nullptr) {
        column.Set(value, static_cast<double>(reference++ % column.rows()));
      } else if (is_vector) {
        column.Set(value, draw(-1, 1));
      } else if (is_none) {
        column.Set(value, -1);
      } else if (is_shape) {
        column.Set(value, std::floor(draw(0, kShapes)));
      } else {
        column.Set(value, is_size ? draw(0.2, 0.6) : draw(0.5, 2));
      }
    }
    if (is_rotation) Normalise(column, row);
  }
}

const AnyColumn& World::operator[](const std::string& name) const {
  for (const AnyColumn& column : columns_) {
    if (column.descriptor().name == name) return column;
  }
  throw std::logic_error("the world has no property " + name);
}

AnyColumn& World::operator[](const std::string& name) {
  return const_cast<AnyColumn&>(std::as_const(*this)[name]);
}

AnyColumn& World::ColumnOf(const vesper_property& used) {
  const auto column = std::ranges::find_if(columns_, [&](const AnyColumn& each) {
    return IsUsed(each.descriptor(), used.name, used.kind, used.access);
  });
  if (column == columns_.end()) {
    throw std::logic_error("the world has no property " + std::string(used.name));
  }
  return *column;
}

void World::Clear(const std::string& name) {
  AnyColumn& column = (*this)[name];
  for (uint64_t i = 0; i < column.size(); ++i) column.Set(i, 0);
}

void World::Translate(const Vec3<double>& by) {
  for (AnyColumn& column : columns_) {
    if (!IsPlace(column.descriptor().name)) continue;
    for (uint64_t row = 0; row < column.rows(); ++row) {
      column.SetVector(row, column.GetVector(row) + by);
    }
  }
  for (AnalyticField& field : fields_) field.Translate(by);
}

void World::Rotate(const Quaternion& by) {
  for (AnyColumn& column : columns_) {
    if (!column.is_vector()) continue;
    for (uint64_t row = 0; row < column.rows(); ++row) {
      column.SetVector(row, Rotated(column.GetVector(row), by));
    }
  }
  for (AnyColumn& column : columns_) {
    if (IsRotation(column.descriptor().name)) RotateRows(column, by);
  }
  for (AnalyticField& field : fields_) field.Rotate(by);
}

std::vector<vesper_property> World::PropertiesFor(const vesper_law_desc& law) {
  std::vector<vesper_property> properties;
  for (const auto& use : std::span(law.uses, law.use_count)) properties.push_back(PropertyFor(use));
  return properties;
}

vesper_property World::PropertyFor(const vesper_property_use& use) {
  vesper_property property{sizeof property, use.scalar_type, use.name, use.kind, use.components,
                           use.access,      nullptr,         0,        0};
  for (AnalyticField& field : fields_) {
    if (field.descriptor().name != std::string(use.name)) continue;
    property.data = const_cast<vesper_field*>(&field.function());
    return property;
  }
  AnyColumn& column = ColumnOf(property);
  property.data = column.data();
  property.row_count = column.rows();
  return property;
}

PhysicsEngine World::MakeEngine(const std::string& library, uint32_t threads, bool validate) {
  PhysicsEngine engine(prototype_, {.threads = threads, .validate = validate});
  for (AnyColumn& column : columns_) {
    if (!IsScratch(column.descriptor())) column.AddTo(engine.PropertyProvider());
  }
  for (AnalyticField& field : fields_) {
    const char* name = field.descriptor().name;
    if (!brought_.contains(name)) engine.PropertyProvider().SetField(name, field.function());
  }
  Load(engine, library);
  return engine;
}

vesper_library_id World::Load(PhysicsEngine& engine, const std::string& library,
                              const std::vector<ParameterValue>& parameters) const {
  if (!LawFile::IsPython(library)) return engine.LoadPhysicsLaw(library, parameters);
  return engine.LoadPhysicsLaw(LawFile::Prepare(prototype_, library), parameters);
}

}  // namespace vesper
