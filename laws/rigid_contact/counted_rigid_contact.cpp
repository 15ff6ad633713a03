// SPDX-License-Identifier: Apache-2.0
// The law rigid_contact, which writes the amount of its work in each step to the log.
#include <cstdio>

#include "rigid_contact.hpp"

namespace {

template <class Real>
struct CountedRigidContact : vesper::rigid::RigidContact<Real> {
  static constexpr auto kName = "counted_rigid_contact";

  void Advance(const vesper::Step& step) {
    vesper::rigid::RigidContact<Real>::Advance(step);
    char line[64];
    std::snprintf(line, sizeof line, "pairs %zu contacts %zu", this->collided_pairs(),
                  this->solved_contacts());
    step.Log(VESPER_LOG_INFO, line);
  }
};

}  // namespace

VESPER_LAW_LIBRARY("counted_rigid_contact", CountedRigidContact)
