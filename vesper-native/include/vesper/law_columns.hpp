// SPDX-License-Identifier: Apache-2.0
// Types for the declarations of a law's properties: units, rows, columns and fields. Part of
// vesper/law.hpp, which laws include.
#ifndef VESPER_LAW_COLUMNS_HPP_
#define VESPER_LAW_COLUMNS_HPP_

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "vesper/law.h"

namespace vesper {

namespace units {
inline constexpr vesper_unit one = VESPER_UNIT_ONE;
inline constexpr vesper_unit metre = VESPER_UNIT_METRE;
inline constexpr vesper_unit kilogram = VESPER_UNIT_KILOGRAM;
inline constexpr vesper_unit second = VESPER_UNIT_SECOND;
inline constexpr vesper_unit kelvin = VESPER_UNIT_KELVIN;
inline constexpr vesper_unit coulomb = VESPER_UNIT_COULOMB;
inline constexpr vesper_unit metre_per_second = VESPER_UNIT_METRE_PER_SECOND;
inline constexpr vesper_unit metre_per_second_squared = VESPER_UNIT_METRE_PER_SECOND_SQUARED;
inline constexpr vesper_unit radian_per_second = VESPER_UNIT_RADIAN_PER_SECOND;
inline constexpr vesper_unit newton = VESPER_UNIT_NEWTON;
inline constexpr vesper_unit newton_metre = VESPER_UNIT_NEWTON_METRE;
inline constexpr vesper_unit newton_per_metre = VESPER_UNIT_NEWTON_PER_METRE;
inline constexpr vesper_unit newton_second_per_metre = VESPER_UNIT_NEWTON_SECOND_PER_METRE;
inline constexpr vesper_unit kilogram_metre_squared = VESPER_UNIT_KILOGRAM_METRE_SQUARED;
inline constexpr vesper_unit kilogram_per_metre = VESPER_UNIT_KILOGRAM_PER_METRE;
inline constexpr vesper_unit kilogram_per_second = VESPER_UNIT_KILOGRAM_PER_SECOND;
inline constexpr vesper_unit volt_per_metre = VESPER_UNIT_VOLT_PER_METRE;
inline constexpr vesper_unit tesla = VESPER_UNIT_TESLA;
inline constexpr vesper_unit gravitational_constant = VESPER_UNIT_GRAVITATIONAL_CONSTANT;
inline constexpr vesper_unit coulomb_constant = VESPER_UNIT_COULOMB_CONSTANT;
}  // namespace units

/** Three numbers of one row, with the layout of a column of 3 components. */
template <class Real>
struct Vec3 {
  Real x{}; /**< Component 0. */
  Real y{}; /**< Component 1. */
  Real z{}; /**< Component 2. */

  /** @{ */
  /** Component-wise operations. */
  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3 operator*(Vec3 a, Real s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(Real s, Vec3 a) { return a * s; }
  friend constexpr Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
  friend constexpr Vec3& operator-=(Vec3& a, Vec3 b) { return a = a - b; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
  /** @} */
};

template <class Real>
constexpr Real Dot(Vec3<Real> a, Vec3<Real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
constexpr Vec3<Real> Cross(Vec3<Real> a, Vec3<Real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
Real Length(Vec3<Real> a) {
  return std::sqrt(Dot(a, a));
}

namespace detail {

template <class T>
struct Scalar;
template <>
struct Scalar<float> : std::integral_constant<vesper_scalar_type, VESPER_F32> {};
template <>
struct Scalar<double> : std::integral_constant<vesper_scalar_type, VESPER_F64> {};
template <>
struct Scalar<int32_t> : std::integral_constant<vesper_scalar_type, VESPER_I32> {};
template <>
struct Scalar<uint32_t> : std::integral_constant<vesper_scalar_type, VESPER_U32> {};

/** Scalar type and number of components of a row type. */
template <class Row>
struct RowType {
  static constexpr vesper_scalar_type kScalar = Scalar<Row>::value;
  static constexpr uint32_t kComponents = 1;
};
template <class Real>
struct RowType<Vec3<Real>> {
  static constexpr vesper_scalar_type kScalar = Scalar<Real>::value;
  static constexpr uint32_t kComponents = 3;
};
template <class T, std::size_t n>
struct RowType<std::array<T, n>> {
  static constexpr vesper_scalar_type kScalar = Scalar<T>::value;
  static constexpr uint32_t kComponents = n;
};

template <class Law>
class Instance;

}  // namespace detail

/** A column that a law uses: (rows x components of Row), memory of the client that stays valid
 *  until the next Bind. Row is float, double, int32_t, uint32_t, Vec3 of a real, or std::array of a
 *  scalar. Elements are const if the access is read-only. Use it through the aliases below. */
template <class Row, vesper_access access, uint32_t flags>
class Column {
 public:
  /** Access of the law to the property. */
  static constexpr vesper_access kAccess = access;
  /** Type of a row; const if the access is read-only. */
  using Element = std::conditional_t<access == VESPER_READ, const Row, Row>;

  /** Stores the declaration by which the property is matched. The strings are literals. */
  constexpr Column(const char* name, const char* kind, const vesper_unit& unit)
      : name_(name), kind_(kind), unit_(unit) {}

  /** Returns row `row`, which must be less than size(); not checked. */
  Element& operator[](uint64_t row) const { return data_[row]; }
  /** Returns the first row; null if there is none. */
  Element* data() const { return data_; }
  /** Returns the first row. */
  Element* begin() const { return data_; }
  /** Returns the position behind the last row. */
  Element* end() const { return data_ + size_; }
  /** Returns the number of rows; 0 if an optional property is absent. */
  uint64_t size() const { return size_; }
  /** Returns the name of the property. */
  const char* name() const { return name_; }
  /** Returns a number that changes when the client touches or rebinds the property. For a
   *  Deferred column, it changes whenever the client or another library writes the array. */
  uint64_t version() const { return version_; }
  /** Returns false if the prototype lacks this optional property or the client bound no array to
   *  it. */
  bool present() const
    requires((flags & VESPER_USE_OPTIONAL) != 0)
  {
    return data_ != nullptr;
  }

 private:
  template <class Law>
  friend class detail::Instance;

  constexpr vesper_property_use Use() const {
    using Type = detail::RowType<Row>;
    return {sizeof(vesper_property_use),
            Type::kScalar,
            name_,
            kind_,
            Type::kComponents,
            access,
            unit_,
            flags,
            0};
  }
  void Set(const vesper_property& property) {
    data_ = static_cast<Element*>(property.data);
    size_ = property.row_count;
    version_ = property.version;
  }

  const char* name_;
  const char* kind_;
  vesper_unit unit_;
  Element* data_ = nullptr;
  uint64_t size_ = 0;
  uint64_t version_ = 0;
};

template <class Row>
using Read = Column<Row, VESPER_READ, 0>;
/** A column that the law only writes. Advance must write every row, and must not read the previous
 *  contents. */
template <class Row>
using Write = Column<Row, VESPER_WRITE, 0>;
template <class Row>
using ReadWrite = Column<Row, VESPER_READ_WRITE, 0>;
/** A column to which the law adds, in phase kForce only. Each law's column starts at zero; the
 *  engine sums over all laws. */
template <class Row>
using Accumulate = Column<Row, VESPER_ACCUMULATE, 0>;
/** Memory that the engine keeps for this law: one Row for each row of the kind, initially zero. The
 *  law reads and writes it in Advance only. The engine rolls it back if a step fails, saves it with
 *  its state, and moves each value when the client moves the row. The law chooses the name. */
template <class Row>
using Scratch = Column<Row, VESPER_SCRATCH, 0>;
template <class Row>
using OptionalRead = Column<Row, VESPER_READ, VESPER_USE_OPTIONAL>;
template <class Row>
using OptionalWrite = Column<Row, VESPER_WRITE, VESPER_USE_OPTIONAL>;
template <class Row>
using OptionalReadWrite = Column<Row, VESPER_READ_WRITE, VESPER_USE_OPTIONAL>;
template <class Row>
using OptionalAccumulate = Column<Row, VESPER_ACCUMULATE, VESPER_USE_OPTIONAL>;

/** A column that the laws of a library copy into their Suite, for example to a GPU. If version()
 *  differs from the version of the copy, Bind must read the array. Otherwise the copy is valid, and
 *  may contain newer values than the array. Advance works on the copy only. When the engine needs
 *  the written values, it calls law.Synchronize(column), which must fill the whole column. See
 *  VESPER_USE_DEFERRED in law.h. */
template <class Row>
using DeferredRead = Column<Row, VESPER_READ, VESPER_USE_DEFERRED>;
template <class Row>
using OptionalDeferredRead = Column<Row, VESPER_READ, VESPER_USE_OPTIONAL | VESPER_USE_DEFERRED>;
template <class Row>
using DeferredWrite = Column<Row, VESPER_WRITE, VESPER_USE_DEFERRED>;
template <class Row>
using DeferredReadWrite = Column<Row, VESPER_READ_WRITE, VESPER_USE_DEFERRED>;
template <class Row>
using DeferredAccumulate = Column<Row, VESPER_ACCUMULATE, VESPER_USE_DEFERRED>;

/** A function of position that a law reads, for example wind or a magnetic field. Value is a
 *  real or Vec3 of one, in the declared unit. Evaluate computes many positions in one call. */
template <class Value, uint32_t flags>
class FieldOf {
 public:
  /** Fields are read-only. */
  static constexpr vesper_access kAccess = VESPER_READ;

  /** Stores the declaration by which the property is matched. The strings are literals. */
  constexpr FieldOf(const char* name, const char* kind, const vesper_unit& unit)
      : name_(name), kind_(kind), unit_(unit) {}

  /** Returns the value at a position [m]. */
  template <class Real>
  Value operator()(const Vec3<Real>& at) const {
    const double from[3] = {at.x, at.y, at.z};
    double out[kComponents];
    field_->evaluate(field_->user, 1, from, out);
    if constexpr (kComponents == 1) {
      return static_cast<Value>(out[0]);
    } else {
      return {static_cast<Real>(out[0]), static_cast<Real>(out[1]), static_cast<Real>(out[2])};
    }
  }
  /** Writes values to `out` (count x components) for the positions `at` (count x 3) [m]. */
  void Evaluate(uint64_t count, const double* at, double* out) const {
    field_->evaluate(field_->user, count, at, out);
  }
  /** Returns false if the prototype lacks this optional field or no field is bound to it. */
  bool present() const
    requires(flags == VESPER_USE_OPTIONAL)
  {
    return field_ != nullptr;
  }

 private:
  template <class Law>
  friend class detail::Instance;

  static constexpr uint32_t kComponents = detail::RowType<Value>::kComponents;
  static_assert(kComponents == 1 || kComponents == 3, "a field's value is a real or a Vec3");

  constexpr vesper_property_use Use() const {
    return {sizeof(vesper_property_use),
            VESPER_FIELD,
            name_,
            kind_,
            kComponents,
            kAccess,
            unit_,
            flags,
            0};
  }
  void Set(const vesper_property& property) {
    field_ = static_cast<const vesper_field*>(property.data);
  }

  const char* name_;
  const char* kind_;
  vesper_unit unit_;
  const vesper_field* field_ = nullptr;
};

template <class Value>
using Field = FieldOf<Value, 0>;
template <class Value>
using OptionalField = FieldOf<Value, VESPER_USE_OPTIONAL>;

}  // namespace vesper

#endif  // VESPER_LAW_COLUMNS_HPP_
