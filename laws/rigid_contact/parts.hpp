// SPDX-License-Identifier: Apache-2.0
// Attached shapes that are parts of rigid bodies.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "shape.hpp"

namespace vesper::rigid {

/** A shape that is a part of a body. */
struct Part {
  uint32_t row, body;
  Shape shape;
  // Pose in the axes of the body.
  Vector offset;
  Quaternion turn;
};

/** The parts of all bodies in a step, in the order of their rows. */
class Parts {
 public:
  void Reset(uint64_t rows) {
    parts_.clear();
    sums_.clear();
    rows_ = rows;
  }

  /** Adds a part. The shape of the part and the poses of the part and of its body are given in the
   *  world's reference frame. */
  void Add(uint32_t row, uint32_t body, const Shape& shape, const Quaternion& rotation,
           const Vector& at, const Quaternion& of_body) {
    const Quaternion inverse = of_body.Inverse();
    parts_.push_back({row, body, shape, inverse.Rotate(shape.position - at), inverse * rotation});
  }

  /** Computes the moments of inertia of all bodies that have parts. Call after the last Add.
   *  `shape_of(row)` returns the own shape of a body. */
  template <class ShapeOf>
  void AddBodies(ShapeOf&& shape_of) {
    body_of_.clear();
    if (parts_.empty()) return;
    body_of_.resize(rows_);
    for (uint32_t i = 0; i < rows_; ++i) body_of_[i] = i;
    for (const Part& part : parts_) {
      body_of_[part.row] = part.body;
      sums_.push_back({part.body, 0, {}});
    }
    std::sort(sums_.begin(), sums_.end(),
              [](const Sum& x, const Sum& y) { return x.body < y.body; });
    sums_.erase(std::unique(sums_.begin(), sums_.end(),
                            [](const Sum& x, const Sum& y) { return x.body == y.body; }),
                sums_.end());
    for (Sum& sum : sums_) {
      const Shape own = shape_of(sum.body);
      sum.volume = own.Volume();
      sum.moments = own.Moments(sum.volume);
    }
    for (const Part& part : parts_) AddTo(*Find(part.body), part);
    for (Sum& sum : sums_) {
      sum.moments = sum.volume > 0 ? sum.moments * (1 / sum.volume) : Vector{};
    }
  }

  const std::vector<Part>& all() const { return parts_; }
  /** Returns the body to which a row belongs: the row itself, or the body of which it is a part. */
  uint32_t BodyOf(uint32_t row) const { return row < body_of_.size() ? body_of_[row] : row; }
  /** Returns the moments of inertia per mass of a body with its parts [m^2], if all have the same
   *  density; null if it has no parts. */
  const Vector* MomentsOf(uint32_t body) const {
    const Sum* sum = sums_.empty() ? nullptr : const_cast<Parts*>(this)->Find(body);
    return sum == nullptr ? nullptr : &sum->moments;
  }

 private:
  struct Sum {
    uint32_t body;
    double volume;   // [m^3]
    Vector moments;  // about the origin of the body, per density [m^5]; at the end per mass [m^2]
  };

  Sum* Find(uint32_t body) {
    const auto found =
        std::lower_bound(sums_.begin(), sums_.end(), body,
                         [](const Sum& sum, uint32_t row) { return sum.body < row; });
    return found != sums_.end() && found->body == body ? &*found : nullptr;
  }

  static void AddTo(Sum& sum, const Part& part) {
    const double volume = part.shape.Volume();
    const Vector own = part.shape.Moments(volume), &d = part.offset;
    const Axes axes = Axes::Of(part.turn);
    const auto about = [&](double x, double y, double z) {
      return x * x * own.x + y * y * own.y + z * z * own.z;
    };
    sum.volume += volume;
    sum.moments += Vector{about(axes.x.x, axes.y.x, axes.z.x) + volume * (d.y * d.y + d.z * d.z),
                          about(axes.x.y, axes.y.y, axes.z.y) + volume * (d.x * d.x + d.z * d.z),
                          about(axes.x.z, axes.y.z, axes.z.z) + volume * (d.x * d.x + d.y * d.y)};
  }

  uint64_t rows_ = 0;
  std::vector<Part> parts_;
  std::vector<uint32_t> body_of_;  // one per row; empty without parts
  std::vector<Sum> sums_;          // sorted by body, ascending
};

}  // namespace vesper::rigid
