#include "vesper/kit/world.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>

namespace vesper {
namespace {

const std::string kOrientation = "orientation", kPosition = "position";

/// Half the side of the box that holds the bodies [m], about one per cubic metre.
double ReachOf(uint64_t bodies) { return std::max(2.0, std::cbrt(static_cast<double>(bodies)) / 2); }

void Normalise(AnyColumn& column, uint64_t row) {
  const uint32_t n = column.descriptor().components;
  double square = 0;
  for (uint64_t i = row * n; i < (row + 1) * n; ++i) square += column.Get(i) * column.Get(i);
  for (uint64_t i = row * n; i < (row + 1) * n; ++i) {
    column.Set(i, column.Get(i) / std::sqrt(square));
  }
}

Vec3<double> Rotated(const Vec3<double>& x, const Quaternion& by) {
  const Vec3<double> t = Cross(by.v, x) * 2.0;
  return x + t * by.w + Cross(by.v, t);
}

const vesper_prototype& PrototypeOf(vesper_scalar_type real_type) {
  return StandardPrototype(real_type == VESPER_F64 ? "si-f64" : "si-f32");
}

/// Memory that an engine keeps for a law; where no engine is, a column stands for it.
bool IsScratch(const vesper_property_descriptor& property) {
  return property.law_access == VESPER_SCRATCH;
}

/// Of the prototype, then of the properties that only the laws know: what they declare. Scratch is
/// last.
std::vector<vesper_property_descriptor> DescriptorsFor(
    const vesper_prototype& prototype, const std::vector<const vesper_law_desc*>& laws) {
  std::vector<vesper_property_descriptor> all(prototype.properties,
                                              prototype.properties + prototype.property_count);
  for (const vesper_law_desc* law : laws) {
    for (const auto& use : std::span(law->uses, law->use_count)) {
      const auto known = std::ranges::find_if(
          all, [&](const auto& property) { return property.name == std::string(use.name); });
      if (known == all.end()) {
        all.push_back({sizeof(vesper_property_descriptor), use.scalar_type, use.name, use.kind, use.components, use.access,
                       use.unit, nullptr, nullptr, "Declared by the law."});
      } else if (known >= all.begin() + prototype.property_count) {
        known->law_access |= use.access;
      }
    }
  }
  std::ranges::stable_partition(all, std::not_fn(IsScratch));
  return all;
}

}  // namespace

World::World(vesper_scalar_type real_type, const std::vector<const vesper_law_desc*>& laws,
             uint64_t rows, uint32_t seed)
    : prototype_(PrototypeOf(real_type)), descriptors_(DescriptorsFor(prototype_, laws)) {
  prototype_.properties = descriptors_.data();
  prototype_.property_count = static_cast<uint32_t>(
      std::ranges::count_if(descriptors_, std::not_fn(IsScratch)));
  std::mt19937 random(seed);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (const vesper_property_descriptor& property : descriptors_) {
    const bool single = property.kind == std::string("world");
    columns_.emplace_back(property, single ? std::min<uint64_t>(rows, 1) : rows);
    Fill(columns_.back(), draw);
  }
}

// Each body within a metre of the one before it in every direction: what refers to neighbouring rows
// is then as small as lengths and radii are.
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
  // The engine fills sums, and scratch starts at zero.
  if ((property.law_access & (VESPER_ACCUMULATE | VESPER_SCRATCH)) != 0) return;
  if (property.name == kPosition) return Place(column, draw);
  for (uint64_t row = 0; row < column.rows(); ++row) {
    // Neighbours, so that the rows that one refers to differ.
    auto reference = static_cast<uint64_t>(draw(0, static_cast<double>(column.rows())));
    for (uint32_t c = 0; c < property.components; ++c) {
      const uint64_t value = row * property.components + c;
      if (property.refers_to != nullptr) {
        column.Set(value, static_cast<double>(reference++ % column.rows()));
      } else if (column.is_vector()) {
        column.Set(value, draw(-1, 1));
      } else {
        column.Set(value, draw(0.5, 2));
      }
    }
    if (property.name == kOrientation) Normalise(column, row);
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

void World::Clear(const std::string& name) {
  AnyColumn& column = (*this)[name];
  for (uint64_t i = 0; i < column.size(); ++i) column.Set(i, 0);
}

void World::Translate(const Vec3<double>& by) {
  AnyColumn& position = (*this)[kPosition];
  for (uint64_t row = 0; row < position.rows(); ++row) {
    position.SetVector(row, position.GetVector(row) + by);
  }
}

void World::Rotate(const Quaternion& by) {
  for (AnyColumn& column : columns_) {
    if (!column.is_vector()) continue;
    for (uint64_t row = 0; row < column.rows(); ++row) {
      column.SetVector(row, Rotated(column.GetVector(row), by));
    }
  }
  AnyColumn& orientation = (*this)[kOrientation];
  for (uint64_t row = 0; row < orientation.rows(); ++row) {
    const Vec3<double> v{orientation.Get(4 * row), orientation.Get(4 * row + 1),
                         orientation.Get(4 * row + 2)};
    const double w = orientation.Get(4 * row + 3);
    const Vec3<double> turned = v * by.w + by.v * w + Cross(by.v, v);
    orientation.Set(4 * row, turned.x);
    orientation.Set(4 * row + 1, turned.y);
    orientation.Set(4 * row + 2, turned.z);
    orientation.Set(4 * row + 3, by.w * w - Dot(by.v, v));
  }
}

std::vector<vesper_property> World::PropertiesFor(const vesper_law_desc& law) {
  std::vector<vesper_property> properties;
  for (const auto& use : std::span(law.uses, law.use_count)) {
    AnyColumn& column = (*this)[use.name];
    properties.push_back({sizeof(vesper_property), use.scalar_type, use.name, use.kind,
                          use.components, use.access, column.data(), column.rows(), 0});
  }
  return properties;
}

PhysicsEngine World::MakeEngine(const std::string& library, uint32_t threads, bool validate) {
  PhysicsEngine engine(prototype_, {.threads = threads, .validate = validate});
  for (AnyColumn& column : columns_) {
    if (!IsScratch(column.descriptor())) column.AddTo(engine.PropertyProvider());
  }
  engine.LoadPhysicsLaw(library);
  return engine;
}

}  // namespace vesper
