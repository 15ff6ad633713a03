// SPDX-License-Identifier: Apache-2.0
// Contacts of one colour side by side in the lanes of registers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "colours.hpp"
#include "lanes.hpp"
#include "solver.hpp"

namespace vesper::rigid {

/** Contacts that a processor corrects at once: one in each lane. They move different bodies, have
 *  equally many points, and need only the functions of ContactCore. Lanes without a contact contain
 *  zeros. */
template <class Real>
class Batch {
 public:
  using Number = Lanes<Real>;
  using Motions = std::vector<Motion<Real>>;
  static constexpr int kCount = Number::kCount;

  /** Chooses the contacts of the lanes, at most kCount of them. */
  void Choose(std::span<const uint32_t> contacts) {
    used_ = int(contacts.size());
    for (int lane = 0; lane < used_; ++lane) contacts_[lane] = contacts[lane];
  }

  /** Reads the contacts, and computes their effective masses. */
  void Load(const std::vector<Contact<Real>>& contacts, const Motions& motions) {
    if (used_ < kCount) {
      core_ = {};
      inverse_mass_[0] = inverse_mass_[1] = {};
      inverse_inertia_[0] = inverse_inertia_[1] = {};
      for (auto& rows : bodies_) rows.fill(kImmovable);
    }
    core_.count = contacts[contacts_[0]].count;
    for (int lane = 0; lane < used_; ++lane) {
      const Contact<Real>& from = contacts[contacts_[lane]];
      bodies_[0][lane] = from.a;
      bodies_[1][lane] = from.b;
      for (int side = 0; side < 2; ++side) {
        if (bodies_[side][lane] == kImmovable) {
          inverse_mass_[side].Set(lane, 0);
        } else {
          inverse_mass_[side].Set(lane, motions[bodies_[side][lane]].inverse_mass);
        }
      }
      Set(core_.normal, from.normal, lane);
      for (int k = 0; k < 2; ++k) Set(core_.across[k], from.across[k], lane);
      core_.friction.Set(lane, from.friction);
      for (int i = 0; i < core_.count; ++i) {
        auto& to = core_.points[i];
        const auto& point = from.points[i];
        Set(to.arm_a, point.arm_a, lane);
        Set(to.arm_b, point.arm_b, lane);
        to.separation.Set(lane, point.separation);
        to.press.Set(lane, point.press);
        for (int k = 0; k < 2; ++k) to.rub[k].Set(lane, point.rub[k]);
      }
      LoadInertia(from, motions, lane);
    }
    core_.FindMasses(Resting(0), Resting(1));
  }

  /** Computes the effective masses again, if the inertia of a body has changed.
   *  @param is_renewed returns whether the inertia of a movable body has changed
   *  @param renew computes directions and masses of a contact, given by its index */
  template <class IsRenewed, class Compute>
  void Renew(const std::vector<Contact<Real>>& contacts, const Motions& motions,
             IsRenewed&& is_renewed, Compute&& renew) {
    for (int lane = 0; lane < used_; ++lane) {
      if (!is_renewed(bodies_[0][lane]) && !is_renewed(bodies_[1][lane])) continue;
      renew(contacts_[lane]);
      const Contact<Real>& from = contacts[contacts_[lane]];
      LoadInertia(from, motions, lane);
      core_.mean_mass.Set(lane, from.mean_mass);
      for (int i = 0; i < core_.count; ++i) {
        auto& to = core_.points[i];
        const auto& point = from.points[i];
        to.mass.Set(lane, point.mass);
        to.across_mass.Set(lane, point.across_mass);
        for (int k = 0; k < 3; ++k) to.across[k].Set(lane, point.across[k]);
      }
    }
  }

  void WarmStart(Motions& motions) const {
    Motion<Number> a = Gather(0, motions), b = Gather(1, motions);
    core_.WarmStart(a, b);
    Scatter(0, a, motions);
    Scatter(1, b, motions);
  }

  /** Corrects the impulses, as Contact::Solve does. */
  void Solve(Motions& motions, const SolverStep<Real>& step, bool push) {
    Motion<Number> a = Gather(0, motions), b = Gather(1, motions);
    core_.Rub(a, b);
    core_.PressApart(a, b, step, push);
    Scatter(0, a, motions);
    Scatter(1, b, motions);
  }

  /** Writes the impulses back into the contacts. */
  void Store(std::vector<Contact<Real>>& contacts) const {
    for (int lane = 0; lane < used_; ++lane) {
      Contact<Real>& to = contacts[contacts_[lane]];
      for (int i = 0; i < core_.count; ++i) {
        const auto& from = core_.points[i];
        to.points[i].press = from.press[lane];
        for (int k = 0; k < 2; ++k) to.points[i].rub[k] = from.rub[k][lane];
      }
    }
  }

 private:
  static void Set(Vec3<Number>& to, const Vec3<Real>& from, int lane) {
    to.x.Set(lane, from.x);
    to.y.Set(lane, from.y);
    to.z.Set(lane, from.z);
  }

  /** Reads what changes with the inertia of the bodies in the world frame. */
  void LoadInertia(const Contact<Real>& from, const Motions& motions, int lane) {
    Set(core_.mean_arm_a, from.mean_arm_a, lane);
    Set(core_.mean_arm_b, from.mean_arm_b, lane);
    for (int side = 0; side < 2; ++side) {
      const uint32_t body = bodies_[side][lane];
      const Symmetric<Real> of =
          body == kImmovable ? Symmetric<Real>{} : motions[body].inverse_inertia;
      Symmetric<Number>& to = inverse_inertia_[side];
      to.xx.Set(lane, of.xx);
      to.yy.Set(lane, of.yy);
      to.zz.Set(lane, of.zz);
      to.xy.Set(lane, of.xy);
      to.xz.Set(lane, of.xz);
      to.yz.Set(lane, of.yz);
    }
  }

  Motion<Number> Resting(int side) const {
    Motion<Number> motion;
    motion.inverse_mass = inverse_mass_[side];
    motion.inverse_inertia = inverse_inertia_[side];
    return motion;
  }

  // Number of numbers at the beginning of a Motion that Gather reads, and that corrections change.
  static constexpr size_t kRead = 12, kWritten = 6;
  static_assert(offsetof(Motion<Real>, spin) == 3 * sizeof(Real) &&
                offsetof(Motion<Real>, moved) == 6 * sizeof(Real) &&
                offsetof(Motion<Real>, turned) == 9 * sizeof(Real));
  static_assert(kRead % kCount == 0);

  Motion<Number> Gather(int side, const Motions& motions) const {
    static constexpr Motion<Real> kStill{};
    std::array<Number, kRead> read;
    for (size_t at = 0; at < kRead; at += kCount) {
      std::array<const Real*, kCount> rows;
      for (int lane = 0; lane < kCount; ++lane) {
        const uint32_t body = bodies_[side][lane];
        rows[lane] = NumbersOf(body == kImmovable ? kStill : motions[body]) + at;
      }
      std::ranges::copy(Number::LoadColumns(rows), read.begin() + ptrdiff_t(at));
    }
    Motion<Number> to = Resting(side);
    to.velocity = {read[0], read[1], read[2]};
    to.spin = {read[3], read[4], read[5]};
    to.moved = {read[6], read[7], read[8]};
    to.turned = {read[9], read[10], read[11]};
    return to;
  }

  /** Writes the velocities. In single precision, also writes two coordinates of `moved`, which have
   *  not changed. */
  void Scatter(int side, const Motion<Number>& from, Motions& motions) const {
    const std::array<Number, 8> numbers = {from.velocity.x, from.velocity.y, from.velocity.z,
                                           from.spin.x,     from.spin.y,     from.spin.z,
                                           from.moved.x,    from.moved.y};
    Motion<Real> nowhere;
    for (size_t at = 0; at < kWritten; at += kCount) {
      std::array<Real*, kCount> rows;
      for (int lane = 0; lane < kCount; ++lane) {
        const uint32_t body = bodies_[side][lane];
        rows[lane] = NumbersOf(body == kImmovable ? nowhere : motions[body]) + at;
      }
      std::array<Number, kCount> columns;
      std::copy_n(numbers.begin() + ptrdiff_t(at), kCount, columns.begin());
      Number::StoreColumns(columns, rows);
    }
  }

  /** Returns the address of the first number of a motion. */
  static const Real* NumbersOf(const Motion<Real>& motion) {
    return reinterpret_cast<const Real*>(&motion);
  }
  static Real* NumbersOf(Motion<Real>& motion) { return reinterpret_cast<Real*>(&motion); }

  int used_ = 0;                                        // number of lanes with a contact
  std::array<uint32_t, kCount> contacts_{};             // index of the contact of each lane
  std::array<std::array<uint32_t, kCount>, 2> bodies_;  // bodies a and b of each lane
  std::array<Number, 2> inverse_mass_;                  // of the bodies a and b [1/kg]
  std::array<Symmetric<Number>, 2> inverse_inertia_;    // [1/(kg m^2)]
  ContactCore<Number> core_;
};

/** The contacts of a step in batches, and the contacts that no batch contains, by colour. */
template <class Real>
class Batches {
 public:
  /** Chooses the batches. Contacts of the last colour may move the same body, so no batch contains
   *  them. */
  void Choose(const std::vector<Contact<Real>>& contacts, const Colours& colours) {
    count_ = 0;
    singles_.clear();
    for (uint32_t colour = 0; colour < Colours::kMost; ++colour) {
      first_batch_[colour] = count_;
      first_single_[colour] = uint32_t(singles_.size());
      const auto all = colours.order().subspan(colours.first(colour),
                                               colours.first(colour + 1) - colours.first(colour));
      for (auto& equal : by_count_) equal.clear();
      for (const uint32_t i : all) {
        if (colour == Colours::kMost - 1 || !contacts[i].IsPlain()) {
          singles_.push_back(i);
        } else {
          by_count_[size_t(contacts[i].count - 1)].push_back(i);
        }
      }
      for (const auto& equal : by_count_) Split(equal);
    }
    first_batch_[Colours::kMost] = count_;
    first_single_[Colours::kMost] = uint32_t(singles_.size());
  }

  std::span<Batch<Real>> all() { return std::span(batches_).first(count_); }
  /** Returns the batches of a colour. */
  std::span<Batch<Real>> Of(uint32_t colour) {
    return all().subspan(first_batch_[colour], first_batch_[colour + 1] - first_batch_[colour]);
  }
  /** Returns the indices of the contacts that no batch contains. */
  std::span<const uint32_t> singles() const { return singles_; }
  std::span<const uint32_t> SinglesOf(uint32_t colour) const {
    return singles().subspan(first_single_[colour],
                             first_single_[colour + 1] - first_single_[colour]);
  }

 private:
  void Split(std::span<const uint32_t> equal) {
    constexpr size_t kLanes = size_t(Batch<Real>::kCount);
    while (!equal.empty()) {
      const auto some = equal.first(std::min(kLanes, equal.size()));
      equal = equal.subspan(some.size());
      if (some.size() == 1) {  // a batch costs more than a single contact
        singles_.push_back(some[0]);
        continue;
      }
      if (count_ == batches_.size()) batches_.emplace_back();
      batches_[count_++].Choose(some);
    }
  }

  std::vector<Batch<Real>> batches_;  // the first count_ are those of this step
  uint32_t count_ = 0;
  std::vector<uint32_t> singles_;
  std::array<uint32_t, Colours::kMost + 1> first_batch_{}, first_single_{};
  std::array<std::vector<uint32_t>, Manifold::kMost> by_count_;  // contacts of a colour by points
};

}  // namespace vesper::rigid
