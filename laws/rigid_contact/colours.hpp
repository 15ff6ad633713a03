// SPDX-License-Identifier: Apache-2.0
// Graph colouring of contacts: contacts of one colour move different bodies.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "solver.hpp"

namespace vesper::rigid {

/** The order in which a step solves its contacts: one colour after the other. Contacts of one
 *  colour move different bodies, so threads can solve them at the same time, and the result does
 *  not depend on the number of threads. */
class Colours {
 public:
  // The last colour holds the contacts that fit into no other colour; one thread solves them in
  // order.
  static constexpr uint32_t kMost = 64;

  template <class Contacts>
  void Choose(const Contacts& contacts, uint64_t bodies) {
    used_.assign(bodies, 0);
    colour_.resize(contacts.size());
    first_.assign(kMost + 1, 0);
    for (size_t i = 0; i < contacts.size(); ++i) {
      const uint32_t a = contacts[i].a, b = contacts[i].b;
      const uint64_t taken =
          (a == kImmovable ? 0 : used_[a]) | (b == kImmovable ? 0 : used_[b]) | (1ull << 63);
      const auto colour = taken == UINT64_MAX ? kMost - 1 : uint32_t(std::countr_one(taken));
      if (colour < kMost - 1) {
        if (a != kImmovable) used_[a] |= 1ull << colour;
        if (b != kImmovable) used_[b] |= 1ull << colour;
      }
      colour_[i] = colour;
      ++first_[colour + 1];
    }
    for (uint32_t c = 0; c < kMost; ++c) first_[c + 1] += first_[c];
    order_.resize(contacts.size());
    next_.assign(first_.begin(), first_.end() - 1);
    for (size_t i = 0; i < contacts.size(); ++i) order_[next_[colour_[i]]++] = uint32_t(i);
  }

  /** Returns the contacts in the order of their colours. */
  std::span<const uint32_t> order() const { return order_; }
  /** Returns the index in order() at which a colour begins; for kMost, the number of contacts. */
  uint32_t first(uint32_t colour) const { return first_[colour]; }

 private:
  std::vector<uint64_t> used_;    // one per body: the colours of its contacts, as bits
  std::vector<uint32_t> colour_;  // colour of each contact
  std::vector<uint32_t> first_;   // start of each colour in order_ (kMost + 1)
  std::vector<uint32_t> next_;    // (kMost) place in order_ of the next contact of a colour
  std::vector<uint32_t> order_;   // indices of the contacts, sorted by colour
};

}  // namespace vesper::rigid
