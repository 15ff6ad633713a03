// SPDX-License-Identifier: Apache-2.0
/* Eigen maps of the rows and columns of a law, for vector expressions close to the equations:
 *
 *     const auto r = VectorAt(position, i) - centre;
 *     VectorAt(force, i) -= mass[i] * omega.cross(omega.cross(r));
 *
 * Only laws that include this header need Eigen (3.4, Debian package libeigen3-dev). Maps own and
 * copy nothing. The map of a read-only column is const.
 *
 * By default, the order of Eigen's sums depends on the vector unit of the target CPU. This header
 * disables Eigen's own vectorisation, in every Eigen header that follows it, and Eigen's threads.
 * Therefore results depend neither on the CPU nor on compiler flags. The compiler still vectorises
 * loops if this does not change the results. In builds without NDEBUG, a failed assertion of Eigen
 * throws an exception, and the engine reports LAW_FAILED.
 *
 * Whole-column expressions allocate memory only if Eigen needs a temporary. Fixed-size vectors and
 * element-wise arithmetic need none; products of dynamic matrices need one.
 */
#ifndef VESPER_LAW_EIGEN_HPP_
#define VESPER_LAW_EIGEN_HPP_

#if defined(EIGEN_WORLD_VERSION) && !defined(EIGEN_DONT_VECTORIZE)
#error \
    "include vesper/law_eigen.hpp before any header of Eigen: it switches off \
what makes bits depend on the CPU"
#endif

#include <stdexcept>

#ifndef EIGEN_DONT_VECTORIZE
/** Disables Eigen's vectorisation, because with it the bits of results would depend on the CPU. */
#define EIGEN_DONT_VECTORIZE
#endif
#ifndef EIGEN_DONT_PARALLELIZE
/** Disables Eigen's threads, because laws must not start threads. */
#define EIGEN_DONT_PARALLELIZE
#endif
#if !defined(NDEBUG) && !defined(eigen_assert)
/** Makes a failed assertion of Eigen throw, so that the law fails and the process continues. */
#define eigen_assert(condition) \
  ((condition) ? static_cast<void>(0) : throw std::logic_error("Eigen: expected " #condition))
#endif

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <type_traits>

#include "vesper/law.hpp"

namespace vesper {
namespace detail {

/** The C++ type of one component of a row. */
template <class Row>
struct ComponentOf {
  using Type = Row;
};
template <class Real>
struct ComponentOf<Vec3<Real>> {
  using Type = Real;
};
template <class T, std::size_t n>
struct ComponentOf<std::array<T, n>> {
  using Type = T;
};

/** T, const if the elements of the column are const. */
template <class Column, class T>
using ConstAs =
    std::conditional_t<std::is_const_v<typename Column::Element>, std::add_const_t<T>, T>;

template <class Column>
using RowOf = std::remove_const_t<typename Column::Element>;
template <class Column>
using Component = ConstAs<Column, typename ComponentOf<RowOf<Column>>::Type>;
template <class Column>
inline constexpr int kComponentsOf = static_cast<int>(RowType<RowOf<Column>>::kComponents);

}  // namespace detail

/** Returns row `row` of a column as a vector (components x 1); valid as long as the column is
 *  bound. */
template <class Row, vesper_access access, uint32_t flags>
auto VectorAt(const Column<Row, access, flags>& column, uint64_t row) {
  using C = Column<Row, access, flags>;
  using Component = detail::Component<C>;
  using Vector = Eigen::Matrix<std::remove_const_t<Component>, detail::kComponentsOf<C>, 1>;
  return Eigen::Map<detail::ConstAs<C, Vector>>(reinterpret_cast<Component*>(&column[row]));
}

/** Returns a whole column as an array (components x rows) for element-wise arithmetic; valid as
 *  long as the column is bound. Empty if an optional property is absent. */
template <class Row, vesper_access access, uint32_t flags>
auto ArrayOf(const Column<Row, access, flags>& column) {
  using C = Column<Row, access, flags>;
  using Component = detail::Component<C>;
  using Array =
      Eigen::Array<std::remove_const_t<Component>, detail::kComponentsOf<C>, Eigen::Dynamic>;
  return Eigen::Map<detail::ConstAs<C, Array>>(reinterpret_cast<Component*>(column.data()),
                                               detail::kComponentsOf<C>,
                                               static_cast<Eigen::Index>(column.size()));
}

/** Returns row `row` of a column of unit quaternions xyzw, such as `orientation`; valid as long as
 *  the column is bound. */
template <std::floating_point Real, vesper_access access, uint32_t flags>
auto QuaternionAt(const Column<std::array<Real, 4>, access, flags>& column, uint64_t row) {
  using C = Column<std::array<Real, 4>, access, flags>;
  return Eigen::Map<detail::ConstAs<C, Eigen::Quaternion<Real>>>(column[row].data());
}

}  // namespace vesper

#endif  // VESPER_LAW_EIGEN_HPP_
