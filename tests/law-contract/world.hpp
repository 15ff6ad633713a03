// A random world with a column for every property of a standard prototype, for laws of any kind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "vesper/law.hpp"
#include "vesper/vesper.hpp"

namespace vesper {

/// (rows x components) of any scalar type, seen as doubles.
class AnyColumn {
 public:
  AnyColumn(const vesper_property_descriptor& descriptor, uint64_t rows);

  const vesper_property_descriptor& descriptor() const { return *descriptor_; }
  uint64_t rows() const { return rows_; }
  uint64_t size() const { return rows_ * descriptor_->components; }
  bool is_real() const;
  /// True if the three components of a row turn with the world.
  bool is_vector() const;
  void* data() { return bytes_.data(); }
  const std::vector<std::byte>& bytes() const { return bytes_; }

  double Get(uint64_t value) const;
  void Set(uint64_t value, double to);
  /// Of a column with three components.
  Vec3<double> GetVector(uint64_t row) const;
  void SetVector(uint64_t row, const Vec3<double>& to);
  /// Largest absolute value.
  double Largest() const;
  void AddTo(PhysicalPropertyProvider provider);

 private:
  template <class Action>
  static auto Visit(vesper_scalar_type type, Action&& action);

  const vesper_property_descriptor* descriptor_;
  uint64_t rows_;
  std::vector<std::byte> bytes_;
};

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
