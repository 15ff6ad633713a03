// SPDX-License-Identifier: Apache-2.0
// Inverse-square forces between all pairs of bodies, for gravitation and electrostatics. Each pair
// is computed once and acts on both of its bodies.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "all_pairs/pair_sums.hpp"
#include "vesper/law.hpp"

namespace vesper {

/** Sums over all pairs of bodies. The bodies (rows) are divided into shares, and each share is one
 *  task. The number of shares depends on the number of bodies only. Each share has separate sums,
 *  which are added in order. Therefore the result has the same bits for any number of threads. With
 *  portable roots, it also has the same bits on every processor. */
template <class Real>
class AllPairs {
 public:
  explicit AllPairs(InstructionSet set = BestInstructionSet()) : set_(set) {}

  /** Allocates space for this number of bodies. A share has sums for its own rows and for all later
   *  rows. */
  void Resize(uint64_t bodies) {
    packets_.resize((bodies + kSize - 1) / kSize);
    const uint64_t count = packets_.size();
    const uint64_t shares = std::clamp<uint64_t>(count / kRowsOfShare, 1, kMaxShares);
    shares_.clear();
    uint64_t sums = 0;
    for (uint64_t s = 0; s < shares; ++s) {
      // Row p is paired with count - p packets, so the work of the rows from p on is proportional
      // to (count - p)^2. Shares have equal work if this square decreases by the same amount in
      // each.
      const double left = std::sqrt(1.0 - static_cast<double>(s) / static_cast<double>(shares));
      const uint64_t first = count - static_cast<uint64_t>(left * static_cast<double>(count));
      shares_.push_back({first, sums});
      sums += count - first;
    }
    sums_.resize(sums);
  }

  /** Adds to each body's force [N]
   *
   *      constant w_i sum over j of w_j (x_j - x_i) / (|x_j - x_i|^2 + softening^2)^(3/2)
   *
   *  with its weight w, its position x [m] and the softening [m]. The columns have one row per
   *  body; the number of bodies is that of Resize. `step` has a function ParallelFor like
   *  vesper::Step. */
  template <class Step>
  void Attract(const Step& step, ReciprocalRoot root, double constant, double softening,
               std::span<const Real> weight, std::span<const Vec3<Real>> position,
               std::span<Vec3<Real>> force) {
    const Scales scales = Pack(weight, position, softening);
    const auto softening2 = std::max(static_cast<Real>(Square(softening * scales.length)), kLeast);
    step.ParallelFor(shares_.size(), 1, [&](uint64_t begin, uint64_t end) {
      for (uint64_t s = begin; s < end; ++s) SumShare(s, root, softening2);
    });
    const double factor = constant * Square(scales.length / scales.weight);
    step.ParallelFor(packets_.size(), kPacketGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t p = begin; p < end; ++p) {
        const SumPacket<Real> sum = SumOfShares(p);
        const uint64_t first = p * kSize, bodies = std::min(kSize, weight.size() - first);
        for (uint64_t i = 0; i < bodies; ++i) {
          force[first + i] += {static_cast<Real>(factor * static_cast<double>(sum.x[i])),
                               static_cast<Real>(factor * static_cast<double>(sum.y[i])),
                               static_cast<Real>(factor * static_cast<double>(sum.z[i]))};
        }
      }
    });
  }

  /** Returns the sum over the pairs of w_i w_j / sqrt(|x_j - x_i|^2 + softening^2). Two bodies at
   *  one place without softening add nothing. */
  double SumOfPotentials(double softening, std::span<const Real> weight,
                         std::span<const Vec3<Real>> position) const {
    constexpr uint64_t kWide = BodyPacket<double>::kSize;
    std::vector<BodyPacket<double>> packets((weight.size() + kWide - 1) / kWide);
    for (uint64_t i = 0; i < weight.size(); ++i) {
      BodyPacket<double>& packet = packets[i / kWide];
      packet.x[i % kWide] = static_cast<double>(position[i].x);
      packet.y[i % kWide] = static_cast<double>(position[i].y);
      packet.z[i % kWide] = static_cast<double>(position[i].z);
      packet.weight[i % kWide] = static_cast<double>(weight[i]);
    }
    return SumPotentials(set_, packets.data(), packets.size(), Square(softening));
  }

 private:
  static constexpr uint64_t kSize = BodyPacket<Real>::kSize;
  static constexpr uint64_t kRowsOfShare = 8;    // minimum, in packets
  static constexpr uint64_t kMaxShares = 32;     // limits the memory
  static constexpr uint64_t kPacketGrain = 256;  // number of packets in one chunk of a thread
  // Lengths are scaled to below 2^kExtent and weights to below 2^kHeaviest. Then a pair's r^-3
  // times both weights is finite for any small distance, and keeps its digits for any large
  // distance and small weight. kLeast, the minimum of softening squared, keeps r^-3 finite where
  // bodies coincide.
  static constexpr bool kSingle = sizeof(Real) == 4;
  static constexpr int kExtent = kSingle ? 0 : 100, kHeaviest = kSingle ? 4 : 0;
  static constexpr Real kLeast = kSingle ? Real(0x1p-78) : Real(0x1p-600);

  struct Share {
    uint64_t first;  // first row, in packets; the share ends before the first row of the next share
    uint64_t sums;   // offset of the share's sums in sums_
  };
  struct Scales {
    double length, weight;  // powers of two
  };

  static double Square(double x) { return x * x; }

  /** Returns the power of two that scales x > 0 to [1/2, 1) * 2^exponent. */
  static double Scale(double x, int exponent) {
    if (!(x > 0) || !std::isfinite(x)) return 1;
    int own = 0;
    std::frexp(x, &own);
    return std::ldexp(1.0, exponent - own);
  }

  /** Fills the packets; unused lanes of the last packet get weight 0 and a distant position. */
  Scales Pack(std::span<const Real> weight, std::span<const Vec3<Real>> position,
              double softening) {
    const uint64_t bodies = weight.size();
    Vec3<Real> extent;
    Real heaviest = 0;
    for (uint64_t i = 0; i < bodies; ++i) {
      extent = {std::max(extent.x, std::abs(position[i].x)),
                std::max(extent.y, std::abs(position[i].y)),
                std::max(extent.z, std::abs(position[i].z))};
      heaviest = std::max(heaviest, std::abs(weight[i]));
    }
    const double largest = static_cast<double>(std::max({extent.x, extent.y, extent.z}));
    const Scales scales{Scale(std::max(largest, softening), kExtent),
                        Scale(static_cast<double>(heaviest), kHeaviest)};
    const auto scaled = [](Real x, double by) {
      return static_cast<Real>(static_cast<double>(x) * by);
    };
    for (uint64_t i = 0; i < bodies; ++i) {
      BodyPacket<Real>& packet = packets_[i / kSize];
      packet.x[i % kSize] = scaled(position[i].x, scales.length);
      packet.y[i % kSize] = scaled(position[i].y, scales.length);
      packet.z[i % kSize] = scaled(position[i].z, scales.length);
      packet.weight[i % kSize] = scaled(weight[i], scales.weight);
    }
    for (uint64_t i = bodies; i < packets_.size() * kSize; ++i) {
      packets_.back().x[i % kSize] = std::ldexp(Real(4), kExtent);
    }
    return scales;
  }

  void SumShare(uint64_t s, ReciprocalRoot root, Real softening2) {
    const uint64_t first = shares_[s].first, count = packets_.size();
    const uint64_t last = s + 1 < shares_.size() ? shares_[s + 1].first : count;
    SumPacket<Real>* sums = sums_.data() + shares_[s].sums;
    std::fill_n(sums, count - first, SumPacket<Real>{});
    SumPairs(set_, root, packets_.data() + first, last - first, count - first, softening2, sums);
  }

  SumPacket<Real> SumOfShares(uint64_t p) const {
    SumPacket<Real> total{};
    for (const Share& share : shares_) {
      if (share.first > p) break;
      const SumPacket<Real>& sum = sums_[share.sums + p - share.first];
      for (uint64_t i = 0; i < kSize; ++i) {
        total.x[i] += sum.x[i];
        total.y[i] += sum.y[i];
        total.z[i] += sum.z[i];
      }
    }
    return total;
  }

  InstructionSet set_;
  // Each call overwrites all following members.
  std::vector<BodyPacket<Real>> packets_;
  std::vector<Share> shares_;
  std::vector<SumPacket<Real>> sums_;  // the sums of the first share, then of the second, ...
};

}  // namespace vesper
