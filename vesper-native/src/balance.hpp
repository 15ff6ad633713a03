// SPDX-License-Identifier: Apache-2.0
// Momentum, angular momentum and energy of bodies, or the changes of these quantities.
#pragma once

#include <cmath>

namespace vesper {

struct Vector {
  double x = 0, y = 0, z = 0;

  Vector& operator+=(const Vector& other) {
    x += other.x;
    y += other.y;
    z += other.z;
    return *this;
  }
  Vector& operator-=(const Vector& other) { return *this += other * -1; }
  Vector operator*(double factor) const { return {x * factor, y * factor, z * factor}; }
};

inline Vector operator+(Vector a, const Vector& b) { return a += b; }
inline Vector operator-(Vector a, const Vector& b) { return a -= b; }
inline double Dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double Length(const Vector& v) { return std::sqrt(Dot(v, v)); }
inline Vector Cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Balance {
  Vector momentum;          // [kg*m/s]
  Vector angular_momentum;  // [kg*m^2/s], about the origin
  double energy = 0;        // [J], kinetic energy

  Balance& operator+=(const Balance& other) {
    momentum += other.momentum;
    angular_momentum += other.angular_momentum;
    energy += other.energy;
    return *this;
  }
  Balance& operator-=(const Balance& other) {
    momentum -= other.momentum;
    angular_momentum -= other.angular_momentum;
    energy -= other.energy;
    return *this;
  }
};

inline Balance operator+(Balance a, const Balance& b) { return a += b; }
inline Balance operator-(Balance a, const Balance& b) { return a -= b; }

}  // namespace vesper
