// A random world with a column for every property of a standard prototype, for laws of any kind.
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
  /// `rows` of every kind but `world`, which has one (none if `rows` is 0). References name two
  /// different rows where there are two; masses and the like are above zero.
  World(vesper_scalar_type real_type, uint64_t rows, uint32_t seed);

  AnyColumn& operator[](const std::string& name);
  const AnyColumn& operator[](const std::string& name) const;
  std::vector<AnyColumn>& columns() { return columns_; }

  /// Sets every value of a property to zero.
  void Clear(const std::string& name);
  void Translate(const Vec3<double>& by);
  /// Turns vectors and orientations about the origin.
  void Rotate(const Quaternion& by);

  /// Loads one library in validate mode. The world must stay in place from now on.
  PhysicsEngine MakeEngine(const std::string& library, uint32_t threads = 1);

 private:
  void Fill(AnyColumn& column, const std::function<double(double, double)>& draw);

  vesper_scalar_type real_type_;
  std::vector<AnyColumn> columns_;
};

}  // namespace vesper
