// SPDX-License-Identifier: Apache-2.0
// Rotation of vectors.
#pragma once

#include "vesper/law.hpp"

namespace vesper {

/// A unit quaternion: v is the vector part, w the scalar part. The default is the identity.
struct Quaternion {
  Vec3<double> v{};
  double w = 1;

  Quaternion Conjugate() const { return {v * -1.0, w}; }
};

/// Composes rotations: first `b`, then `a`.
inline Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {b.v * a.w + a.v * b.w + Cross(a.v, b.v), a.w * b.w - Dot(a.v, b.v)};
}

inline Vec3<double> Rotated(const Vec3<double>& x, const Quaternion& by) {
  const Vec3<double> t = Cross(by.v, x) * 2.0;
  return x + t * by.w + Cross(by.v, t);
}

}  // namespace vesper
