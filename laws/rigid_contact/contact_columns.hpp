// SPDX-License-Identifier: Apache-2.0
// The columns of bodies that determine how they touch.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>

#include "form.hpp"
#include "substances.hpp"
#include "vesper/law.hpp"

namespace vesper::rigid {

template <class Real>
struct ContactColumns {
  OptionalRead<Real> friction{"friction", "body", units::one};
  OptionalRead<Real> restitution{"restitution", "body", units::one};
  OptionalRead<Real> rolling{"rollingFriction", "body", units::metre};
  OptionalRead<int32_t> layer{"touchLayer", "body", units::one};
  OptionalRead<int32_t> passes{"passesLayers", "body", units::one};
  OptionalRead<int32_t> sensor{"touchSensor", "body", units::one};
  OptionalRead<int32_t> part{"partOfBody", "body", units::one};
  OptionalWrite<int32_t> touch_count{"touchCount", "body", units::one};
  OptionalWrite<Vec3<Real>> reaction{"reactionForce", "body", units::newton};
  OptionalRead<Real> spinning{"spinFriction", "body", units::metre};

  /** Return the columns in three groups, whose places in the order of the law's columns differ. */
  auto FirstProperties() { return std::tie(friction, restitution); }
  auto LaterProperties() {
    return std::tie(rolling, layer, passes, sensor, part, touch_count, reaction);
  }
  auto LastProperties() { return std::tie(spinning); }

  /** Returns the value of a shape: the value of its body, or `otherwise` for scenery. */
  template <class Column>
  static double ValueOf(const Column& column, uint32_t shape, double otherwise) {
    return column.present() && shape < column.size() ? std::max(0.0, double{column[shape]})
                                                     : otherwise;
  }

  /** Returns the values of a body itself, in a world with substances. */
  typename Substances<Real>::Values OwnValues(uint32_t shape) const {
    const auto of = [&](const auto& column) {
      return own::Set(column.present() && shape < column.size() ? double{column[shape]} : 0);
    };
    return {of(friction), of(restitution), of(rolling), of(spinning)};
  }
  /** Returns whether all values of a body that contacts use are finite. */
  bool AreFinite(uint64_t body) const {
    double sum = 0;
    for (const auto* column : {&friction, &restitution, &rolling, &spinning}) {
      if (column->present()) sum += double{(*column)[body]};
    }
    return std::isfinite(sum);
  }

  /** Returns whether two shapes touch: neither passes through the layer of the other. */
  bool Meet(uint32_t a, uint32_t b) const {
    return !passes.present() || !(PassesThrough(a, b) || PassesThrough(b, a));
  }
  /** Returns whether a shape is a sensor, which only counts the shapes that touch it. */
  bool IsSensor(uint32_t shape) const {
    return sensor.present() && shape < sensor.size() && sensor[shape] != 0;
  }
  /** Adds the values of a body that change its contacts to a digest. */
  template <class Digest>
  void AddTo(Digest& digest, uint64_t body) const {
    for (const auto* column : {&friction, &restitution, &rolling, &spinning}) {
      if (column->present()) digest.Add(double{(*column)[body]});
    }
    for (const auto* column : {&layer, &passes, &sensor, &part}) {
      if (column->present()) digest.Add(uint64_t(uint32_t((*column)[body])));
    }
  }
  bool CountsTouches() const { return touch_count.present(); }

  void ClearTouches() const {
    if (touch_count.present()) std::fill(touch_count.begin(), touch_count.end(), 0);
  }
  void CountTouch(uint32_t shape) const {
    if (touch_count.present() && shape < touch_count.size()) ++touch_count[shape];
  }

 private:
  bool PassesThrough(uint32_t shape, uint32_t other) const {
    if (shape >= passes.size()) return false;
    const int32_t number = layer.present() && other < layer.size() ? layer[other] : 0;
    return number >= 0 && number < 32 && ((uint32_t(passes[shape]) >> number) & 1u) != 0;
  }
};

/** The columns that describe meshes: of bodies, of scenery, and of the meshes themselves. */
struct MeshColumns {
  OptionalRead<int32_t> mesh{"meshForm", "body", units::one};
  OptionalRead<int32_t> scenery_mesh{"sceneryMeshForm", "scenery", units::one};
  OptionalRead<Form::Ranges> ranges{"meshRanges", "meshForm", units::one};
  OptionalRead<Vec3<double>> points{"meshPoints", "meshPoint", units::metre};
  OptionalRead<int32_t> indices{"meshIndices", "meshNumber", units::one};

  auto Properties() { return std::tie(mesh, scenery_mesh, ranges, points, indices); }
};

}  // namespace vesper::rigid
