// SPDX-License-Identifier: Apache-2.0
#include "interleave.hpp"

#include <vector>

namespace vesper::text {
namespace {

using namespace asmjit;
namespace Inst = x86::Inst;
using Vec = x86::Vec;

// A lane is a part of a vector with 128 bits: two numbers in f64, or four numbers in f32. Two rows
// (f64) or four rows (f32) of three components fill three lanes. This file calls these lanes first,
// second and third.

Vec Emit(VectorAssembler& vectors, InstId name, const Vec& a, const Vec& b, uint32_t choice) {
  const Vec to = vectors.NewVector();
  vectors.code().emit(name, to, a, b, imm(choice));
  return to;
}

/// Returns lanes i and j of `a`, and lanes k and l of `b` (AVX-512).
Vec Lanes(VectorAssembler& vectors, const Vec& a, int i, int j, const Vec& b, int k, int l) {
  return Emit(vectors, Inst::kIdVshuff64x2, a, b,
              static_cast<uint32_t>(i | j << 2 | k << 4 | l << 6));
}

/// Returns lane i of `a` and lane j of `b` (AVX2).
Vec Lanes(VectorAssembler& vectors, const Vec& a, int i, const Vec& b, int j) {
  return Emit(vectors, Inst::kIdVperm2f128, a, b, static_cast<uint32_t>(i | (2 + j) << 4));
}

/// Returns, in each lane, two numbers of `a` and two numbers of `b` (f32).
Vec Four(VectorAssembler& vectors, const Vec& a, int i, int j, const Vec& b, int k, int l) {
  return Emit(vectors, Inst::kIdVshufps, a, b, static_cast<uint32_t>(i | j << 2 | k << 4 | l << 6));
}

/// Returns, in each lane, number i of `a` and number j of `b` (f64).
Vec Two(VectorAssembler& vectors, const Vec& a, int i, const Vec& b, int j) {
  uint32_t choice = 0;
  for (uint32_t lane = 0; lane < vectors.vector_bytes() / 16; ++lane) {
    choice |= static_cast<uint32_t>(i | j << 1) << (2 * lane);
  }
  return Emit(vectors, Inst::kIdVshufpd, a, b, choice);
}

bool IsF64(const VectorAssembler& vectors) { return vectors.number_bytes() == 8; }
bool IsWide(const VectorAssembler& vectors) { return vectors.vector_bytes() == 64; }

/// Converts three vectors in the order of memory to vectors of all first, all second and all third
/// lanes.
VectorTriple ByLane(VectorAssembler& v, const VectorTriple& memory) {
  const auto& [a, b, c] = memory;
  if (!IsWide(v)) return {Lanes(v, a, 0, b, 1), Lanes(v, a, 1, c, 0), Lanes(v, b, 0, c, 1)};
  const Vec late = Lanes(v, b, 2, 3, c, 1, 2), early = Lanes(v, a, 1, 2, b, 0, 1);
  return {Lanes(v, a, 0, 3, late, 0, 2), Lanes(v, early, 0, 2, late, 1, 3),
          Lanes(v, early, 1, 3, c, 0, 3)};
}

VectorTriple InMemory(VectorAssembler& v, const VectorTriple& lanes) {
  const auto& [first, second, third] = lanes;
  if (!IsWide(v)) {
    return {Lanes(v, first, 0, second, 0), Lanes(v, third, 0, first, 1),
            Lanes(v, second, 1, third, 1)};
  }
  const Vec p = Lanes(v, first, 0, 2, second, 0, 2), q = Lanes(v, third, 0, 2, first, 1, 3),
            s = Lanes(v, second, 1, 3, third, 1, 3);
  return {Lanes(v, p, 0, 2, q, 0, 2), Lanes(v, s, 0, 2, p, 1, 3), Lanes(v, q, 1, 3, s, 1, 3)};
}

void SetLane(VectorAssembler& vectors, const Vec& to, uint32_t lane, const x86::Xmm& value) {
  x86::Compiler& code = vectors.code();
  if (lane == 0) {
    code.vmovaps(to.xmm(), value);
  } else if (IsWide(vectors)) {
    code.vinsertf32x4(to, to, value, imm(lane));
  } else {
    code.vinsertf128(to, to, value, imm(lane));
  }
}

/// Loads one number of each row into a lane.
x86::Xmm LoadLane(VectorAssembler& vectors, const std::vector<x86::Mem>& rows) {
  x86::Compiler& code = vectors.code();
  const x86::Xmm to = code.newXmm();
  if (IsF64(vectors)) {
    code.vmovsd(to, rows[0]);
    code.vmovhpd(to, to, rows[1]);
    return to;
  }
  code.vmovss(to, rows[0]);
  for (uint32_t i = 1; i < 4; ++i) code.vinsertps(to, to, rows[i], imm(i << 4));
  return to;
}

std::vector<x86::Mem> RowsOfLane(VectorAssembler& vectors, uint32_t lane,
                                 const std::function<x86::Mem(uint32_t)>& address_of) {
  std::vector<x86::Mem> rows;
  const uint32_t count = 16 / vectors.number_bytes();
  for (uint32_t i = 0; i < count; ++i) rows.push_back(address_of(lane * count + i));
  return rows;
}

}  // namespace

VectorTriple SplitRows(VectorAssembler& v, const VectorTriple& memory) {
  const auto [first, second, third] = ByLane(v, memory);
  if (IsF64(v)) {  // lanes: x0 y0, z0 x1, y1 z1
    return {Two(v, first, 0, second, 1), Two(v, first, 1, third, 0), Two(v, second, 0, third, 1)};
  }
  // The three lanes contain x0 y0 z0 x1, y1 z1 x2 y2 and z2 x3 y3 z3.
  const Vec late = Four(v, second, 2, 3, third, 1, 2);   // x2 y2 x3 y3
  const Vec early = Four(v, first, 1, 2, second, 0, 1);  // y0 z0 y1 z1
  return {Four(v, first, 0, 3, late, 0, 2), Four(v, early, 0, 2, late, 1, 3),
          Four(v, early, 1, 3, third, 0, 3)};
}

VectorTriple JoinRows(VectorAssembler& v, const VectorTriple& components) {
  const auto& [x, y, z] = components;
  if (IsF64(v)) return InMemory(v, {Two(v, x, 0, y, 0), Two(v, z, 0, x, 1), Two(v, y, 1, z, 1)});
  const Vec a = Four(v, x, 0, 2, y, 0, 2);  // x0 x2 y0 y2
  const Vec b = Four(v, y, 1, 3, z, 1, 3);  // y1 y3 z1 z3
  const Vec c = Four(v, z, 0, 2, x, 1, 3);  // z0 z2 x1 x3
  return InMemory(
      v, {Four(v, a, 0, 2, c, 0, 2), Four(v, b, 0, 2, a, 1, 3), Four(v, c, 1, 3, b, 1, 3)});
}

PlaceMasks MakePlaceMasks(VectorAssembler& v) {
  PlaceMasks masks;
  if (!IsWide(v)) return masks;
  const x86::Gp bits = v.code().newUInt32();
  for (uint32_t place = 0; place < v.lanes() / 4; ++place) {
    masks.push_back(v.code().newKw());
    v.code().mov(bits, imm(0b0111 << (4 * place)));
    v.code().kmovw(masks.back(), bits);
  }
  return masks;
}

namespace {

/// Loads rows into the places of a vector (AVX-512): row `rows[i]` into place i. A masked broadcast
/// needs no shuffle, and does not read behind the three components.
Vec LoadPlaces(VectorAssembler& v, const PlaceMasks& masks, const std::vector<uint32_t>& rows,
               const std::function<x86::Mem(uint32_t)>& address_of) {
  const Vec to = v.Zero();
  for (size_t place = 0; place < masks.size(); ++place) {
    const x86::Mem row = address_of(rows[place]);
    v.code().k(masks[place]);
    v.code().emit(IsF64(v) ? Inst::kIdVbroadcastf64x4 : Inst::kIdVbroadcastf32x4, to, row);
  }
  return to;
}

/// Returns, in each lane, numbers of `a` and `b` in turn: of their first or their second halves.
Vec Alternate(VectorAssembler& v, const Vec& a, const Vec& b, bool second) {
  const InstId f64 = second ? Inst::kIdVunpckhpd : Inst::kIdVunpcklpd;
  const InstId f32 = second ? Inst::kIdVunpckhps : Inst::kIdVunpcklps;
  const Vec to = v.NewVector();
  v.code().emit(IsF64(v) ? f64 : f32, to, a, b);
  return to;
}

/// Returns, in each lane of an f32 vector, the first or the second halves of `a` and `b`.
Vec Halves(VectorAssembler& v, const Vec& a, const Vec& b, bool second) {
  const Vec to = v.NewVector();
  v.code().emit(second ? Inst::kIdVunpckhpd : Inst::kIdVunpcklpd, to, a, b);
  return to;
}

VectorTriple GatherWide(VectorAssembler& v, const PlaceMasks& masks,
                        const std::function<x86::Mem(uint32_t)>& address_of) {
  const auto load = [&](const std::vector<uint32_t>& rows) {
    return LoadPlaces(v, masks, rows, address_of);
  };
  if (IsF64(v)) {
    const Vec a = load({0, 2}), b = load({1, 3}), c = load({4, 6}), d = load({5, 7});
    const Vec xz0 = Alternate(v, a, b, false), xz1 = Alternate(v, c, d, false);
    const Vec y0 = Alternate(v, a, b, true), y1 = Alternate(v, c, d, true);
    return {Lanes(v, xz0, 0, 2, xz1, 0, 2), Lanes(v, y0, 0, 2, y1, 0, 2),
            Lanes(v, xz0, 1, 3, xz1, 1, 3)};
  }
  const Vec a = load({0, 4, 8, 12}), b = load({1, 5, 9, 13}), c = load({2, 6, 10, 14}),
            d = load({3, 7, 11, 15});
  const Vec xy0 = Alternate(v, a, b, false), xy1 = Alternate(v, c, d, false);
  return {Halves(v, xy0, xy1, false), Halves(v, xy0, xy1, true),
          Halves(v, Alternate(v, a, b, true), Alternate(v, c, d, true), false)};
}

}  // namespace

VectorTriple GatherRows(VectorAssembler& v, const PlaceMasks& masks,
                        const std::function<x86::Mem(uint32_t)>& address_of) {
  if (!masks.empty()) return GatherWide(v, masks, address_of);
  x86::Compiler& code = v.code();
  // `early` and `late` contain the first two components of the earlier and the later rows of each
  // lane; `z` contains the third components of all rows.
  const Vec early = v.NewVector(), late = v.NewVector(), z = v.NewVector();
  for (uint32_t lane = 0; lane < v.vector_bytes() / 16; ++lane) {
    std::vector<x86::Mem> rows = RowsOfLane(v, lane, address_of);
    const auto two_of = [&](size_t i) {
      const x86::Xmm to = code.newXmm();
      if (IsF64(v)) {
        code.vmovupd(to, rows[i]);
      } else {
        code.vmovsd(to, rows[2 * i]);
        code.vmovhps(to, to, rows[2 * i + 1]);
      }
      return to;
    };
    SetLane(v, early, lane, two_of(0));
    SetLane(v, late, lane, two_of(1));
    for (x86::Mem& row : rows) row.addOffset(2 * static_cast<int64_t>(v.number_bytes()));
    SetLane(v, z, lane, LoadLane(v, rows));
  }
  if (IsF64(v)) return {Two(v, early, 0, late, 0), Two(v, early, 1, late, 1), z};
  return {Four(v, early, 0, 2, late, 0, 2), Four(v, early, 1, 3, late, 1, 3), z};
}

Vec GatherNumbers(VectorAssembler& v, const std::function<x86::Mem(uint32_t)>& address_of) {
  const Vec to = v.NewVector();
  for (uint32_t lane = 0; lane < v.vector_bytes() / 16; ++lane) {
    SetLane(v, to, lane, LoadLane(v, RowsOfLane(v, lane, address_of)));
  }
  return to;
}

}  // namespace vesper::text
