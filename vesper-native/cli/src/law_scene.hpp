// SPDX-License-Identifier: Apache-2.0
// A scene of bodies and springs in which one law acts, for `vesper law run` and `vesper law plot`.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "vesper/kit/law_file.hpp"
#include "vesper/vesper.hpp"

namespace vesper::cli {

/// The value of a property in all rows, in the property's unit.
struct PropertyValue {
  std::string name;
  std::vector<double> components;
};

/// A law file with the values that its properties have in a scene, in SI units and double
/// precision.
class LawScene {
 public:
  /// Prepares `bodies` bodies of 1 kg and ±1 µC in a cubic grid. If the law uses springs or is an
  /// integrator, a spring connects each body to the next body. `given` replaces the scene's values
  /// of properties, and gives values to properties that only a law as text declares. Loads no law
  /// yet. Throws std::invalid_argument if a given value fits no property.
  LawScene(const std::string& file, uint64_t bodies, const std::vector<PropertyValue>& given);

  const vesper_law_desc& law() const { return *law_; }
  bool Uses(const std::string& property) const;
  /// Returns the distance of neighbours in the grid [m]: the smallest length among the law's
  /// parameters, or 1 m if no parameter is a length.
  double length() const { return length_; }
  uint64_t bodies() const { return bodies_; }
  /// Returns the column of a property: (rows x components).
  std::vector<double>& Column(const std::string& property) { return columns_.at(property); }

  /// Creates the engine and loads the law; throws the engine's error.
  void Load(const std::vector<ParameterValue>& parameters);
  /// Loads another law by its name.
  void LoadMore(const std::string& name);
  void Advance(double dt, uint32_t steps) { engine_->Advance(dt, steps); }
  /// Returns the potential energy of all loaded laws [J]; nothing if no law reports an energy.
  std::optional<double> PotentialEnergy();

 private:
  void Declare(const PropertyValue& given);
  void AddColumns();
  void Arrange();
  void Set(const PropertyValue& given);

  std::string path_;
  LawFile file_;
  const vesper_law_desc* law_;
  uint64_t bodies_;
  double length_ = 1;
  std::vector<vesper_property_descriptor> properties_;  // standard ones, then the law's own
  std::map<std::string, std::vector<double>> columns_;
  std::vector<uint32_t> endpoints_;
  std::optional<PhysicsEngine> engine_;
  std::vector<vesper_library_id> libraries_;
};

}  // namespace vesper::cli
