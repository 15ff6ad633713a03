// A random world with a column for every property of a standard prototype and of a law, for laws of
// any kind.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "vesper/kit/column.hpp"
#include "vesper/law.hpp"
#include "vesper/vesper.hpp"

namespace vesper {

/// A unit quaternion: v the vector part, w the scalar part.
struct Quaternion {
  Vec3<double> v;
  double w;
};

class World {
 public:
  /// A column for every property of the standard prototype, and for those that only the laws know,
  /// whose tables must stay loaded. `rows` of every kind but `world`, which has one (none if `rows`
  /// is 0). References name neighbouring rows, which lie near each other; masses and the like are
  /// above zero.
  World(vesper_scalar_type real_type, const std::vector<const vesper_law_desc*>& laws,
        uint64_t rows, uint32_t seed);

  World(World&&) = default;
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  AnyColumn& operator[](const std::string& name);
  const AnyColumn& operator[](const std::string& name) const;
  std::vector<AnyColumn>& columns() { return columns_; }

  /// Sets every value of a property to zero.
  void Clear(const std::string& name);
  void Translate(const Vec3<double>& by);
  /// Turns vectors and orientations about the origin.
  void Rotate(const Quaternion& by);

  /// The columns that a law uses, in its order.
  std::vector<vesper_property> PropertiesFor(const vesper_law_desc& law);
  /// Loads one library. The world must stay in place from now on.
  PhysicsEngine MakeEngine(const std::string& library, uint32_t threads = 1, bool validate = true);

 private:
  void Place(AnyColumn& column, const std::function<double(double, double)>& draw);
  void Fill(AnyColumn& column, const std::function<double(double, double)>& draw);

  vesper_prototype prototype_;
  std::vector<vesper_property_descriptor> descriptors_;
  std::vector<AnyColumn> columns_;
};

}  // namespace vesper
