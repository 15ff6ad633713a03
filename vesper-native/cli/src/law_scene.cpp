// SPDX-License-Identifier: Apache-2.0
#include "law_scene.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

#include "folders.hpp"

namespace vesper::cli {
namespace {

constexpr double kGravity = 9.81;       // [m/s^2]
constexpr double kCoulomb = 8.98755e9;  // [N*m^2/C^2]
constexpr double kCharge = 1e-6;        // [C]
constexpr double kStiffness = 10;       // [N/m]

std::string WithFolder(const std::string& file) {
  return file.find('/') == std::string::npos ? "./" + file : file;
}

std::string LawPath() {
  std::string path;
  for (const std::string& folder : DefaultLawFolders()) path += (path.empty() ? "" : ":") + folder;
  return path;
}

bool IsMetre(const vesper_unit& unit) {
  const std::span<const int8_t> exponents(unit.exponent);
  return exponents[0] == 1 && std::ranges::count(exponents, 0) == 6;
}

const vesper_law_desc& FirstLaw(const LawFile& file, const std::string& path) {
  const auto laws = file.Laws(VESPER_F64);
  if (laws.empty()) throw std::runtime_error(path + ": has no law in double precision");
  return *laws.front();
}

}  // namespace

LawScene::LawScene(const std::string& file, uint64_t bodies,
                   const std::vector<PropertyValue>& given)
    : path_(WithFolder(file)), file_(path_), law_(&FirstLaw(file_, path_)), bodies_(bodies) {
  vesper_prototype prototype = StandardPrototype("si-f64");
  properties_.assign(prototype.properties, prototype.properties + prototype.property_count);
  for (const PropertyValue& each : given) Declare(each);
  prototype.properties = properties_.data();
  prototype.property_count = static_cast<uint32_t>(properties_.size());
  engine_.emplace(prototype, EngineConfig{.law_path = LawPath()});
  double least = INFINITY;
  for (const auto& parameter : std::span(law_->parameters, law_->parameter_count)) {
    if (IsMetre(parameter.unit) && parameter.default_value > 0) {
      least = std::min(least, parameter.default_value * parameter.unit.scale);
    }
  }
  if (std::isfinite(least)) length_ = least;
  AddColumns();
  Arrange();
  for (const PropertyValue& each : given) Set(each);
}

/// Adds a property that only the law declares to the scene, so that the law uses the scene's
/// values.
void LawScene::Declare(const PropertyValue& given) {
  const auto named = [&](const auto& each) { return each.name == given.name; };
  if (std::ranges::any_of(properties_, named)) return;
  for (const vesper_law_desc* law : file_.Laws(VESPER_F64)) {
    const std::span uses(law->uses, law->use_count);
    const auto use = std::ranges::find_if(uses, named);
    if (use == uses.end() || use->scalar_type != VESPER_F64) continue;
    properties_.push_back({sizeof(vesper_property_descriptor), VESPER_F64, use->name, use->kind,
                           use->components, VESPER_READ | VESPER_WRITE, use->unit, nullptr, nullptr,
                           "Declared by the law.", 0, 0, 0});
    return;
  }
  throw std::invalid_argument("--set " + given.name + ": the law '" + law_->name +
                              "' and the standard properties have no such property");
}

void LawScene::Set(const PropertyValue& given) {
  const auto column = columns_.find(given.name);
  if (column == columns_.end()) {
    throw std::invalid_argument("--set " + given.name +
                                ": the scene has no rows with this property");
  }
  const auto property =
      std::ranges::find_if(properties_, [&](const auto& each) { return each.name == given.name; });
  if (given.components.size() != property->components) {
    throw std::invalid_argument("--set " + given.name + ": found " +
                                std::to_string(given.components.size()) + " numbers, expected " +
                                std::to_string(property->components) + ", in " +
                                property->unit.symbol);
  }
  for (size_t i = 0; i < column->second.size(); ++i) {
    column->second[i] = given.components[i % given.components.size()];
  }
}

bool LawScene::Uses(const std::string& property) const {
  return std::ranges::any_of(std::span(law_->uses, law_->use_count),
                             [&](const vesper_property_use& use) { return use.name == property; });
}

void LawScene::AddColumns() {
  const bool has_springs = Uses("endpoints") || law_->phase == VESPER_PHASE_INTEGRATE;
  const uint64_t springs = has_springs ? bodies_ - 1 : 0;
  for (const vesper_property_descriptor& property : properties_) {
    const std::string kind = property.kind;
    if (property.scalar_type != VESPER_F64) continue;
    const uint64_t rows = kind == "body"     ? bodies_
                          : kind == "spring" ? springs
                          : kind == "world"  ? 1
                                             : 0;
    if (rows > 0) columns_[property.name].resize(rows * property.components);
  }
  for (uint64_t i = 0; i < springs; ++i) {
    endpoints_.push_back(static_cast<uint32_t>(i));
    endpoints_.push_back(static_cast<uint32_t>(i + 1));
  }
}

void LawScene::Arrange() {
  const auto side = static_cast<uint64_t>(std::ceil(std::cbrt(static_cast<double>(bodies_))));
  for (uint64_t i = 0; i < bodies_; ++i) {
    const uint64_t place[] = {i % side, i / side % side, i / side / side};
    for (uint64_t k = 0; k < 3; ++k) {
      Column("position")[3 * i + k] = 1.2 * length_ * static_cast<double>(place[k]);
      // Gives the bodies irregular velocities of at most 0.1 `length_` per second.
      Column("velocity")[3 * i + k] =
          0.1 * length_ * std::sin(12.9898 * static_cast<double>(3 * i + k) + 1);
    }
    Column("mass")[i] = 1;
    Column("charge")[i] = i % 2 == 0 ? kCharge : -kCharge;
    Column("radius")[i] = 0.5 * length_;
    Column("orientation")[4 * i + 3] = 1;
    Column("angularVelocity")[3 * i + 2] = 1;
    Column("linearDragCoefficient")[i] = Column("dragCoefficient")[i] = 0.1;
    std::fill_n(Column("inertia").begin() + static_cast<ptrdiff_t>(3 * i), 3, 1.0);
  }
  if (!endpoints_.empty()) {
    std::ranges::fill(Column("hookeConstant"), kStiffness);
    std::ranges::fill(Column("length"), length_);
  }
  Column("gravity")[1] = -kGravity;
  Column("gravitationalConstant")[0] = 1;
  Column("softening")[0] = 0.3 * length_;
  Column("coulombConstant")[0] = kCoulomb;
  Column("electricField")[1] = 1e6;
  Column("magneticField")[2] = 1e6;
}

void LawScene::Load(const std::vector<ParameterValue>& parameters) {
  auto provider = engine_->PropertyProvider();
  for (auto& [name, values] : columns_) provider.AddPhysicalProperty(name, values);
  if (!endpoints_.empty()) provider.AddPhysicalProperty("endpoints", endpoints_);
  libraries_.push_back(engine_->LoadPhysicsLaw(path_, parameters));
}

void LawScene::LoadMore(const std::string& name) {
  libraries_.push_back(engine_->LoadPhysicsLaw(name));
}

std::optional<double> LawScene::PotentialEnergy() {
  std::optional<double> energy;
  for (const vesper_library_id library : libraries_) {
    const auto laws = engine_->Laws(library);
    for (uint32_t i = 0; i < laws.size(); ++i) {
      try {
        energy = energy.value_or(0) + engine_->PotentialEnergy(library, i);
      } catch (const Error& error) {
        if (error.status() != VESPER_NOT_FOUND) throw;
      }
    }
  }
  return energy;
}

}  // namespace vesper::cli
