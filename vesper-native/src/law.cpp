// SPDX-License-Identifier: Apache-2.0
#include "law.hpp"

#include <chrono>
#include <cmath>
#include <span>

#include "foreign_call.hpp"

namespace vesper {

Law::Law(const vesper_law_desc& desc, const Running& running)
    : desc_(desc), running_(running), label_(std::string("law ") + desc.name) {
  const std::span uses(desc.uses, desc.use_count);
  for (uint32_t i = 0; i < uses.size(); ++i) {
    deferred_.push_back((uses[i].flags & VESPER_USE_DEFERRED) != 0);
  }
}

Law::~Law() {
  if (law_ == nullptr) return;
  const Running::Inside inside(running_);
  CallForeignQuietly([this] { desc_.destroy(law_); });
}

template <class Function>
void Law::Call(Function&& function) {
  const Running::Inside inside(running_);
  CallForeign(label_, function);
}

void Law::Create(const vesper_host& host, vesper_suite* suite,
                 const std::vector<double>& parameters) {
  vesper_law* law = nullptr;
  Call([&](vesper_error* error) {
    return desc_.create(&host, suite, parameters.data(), &law, error);
  });
  if (law == nullptr) {
    throw Failure(VESPER_LAW_MISBEHAVED, "%s: create returned OK but no law", label_.c_str());
  }
  law_ = law;
}

void Law::Bind(const std::vector<vesper_property>& properties) {
  Call([&](vesper_error* error) { return desc_.bind(law_, properties.data(), error); });
}

template <class Function>
void Law::Timed(Function&& function) {
  const auto start = std::chrono::steady_clock::now();
  Call(function);
  const auto spent = std::chrono::steady_clock::now() - start;
  nanoseconds_ +=
      static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(spent).count());
}

void Law::Advance(const vesper_step& step) {
  ++calls_;
  Timed([&](vesper_error* error) { return desc_.advance(law_, &step, error); });
}

void Law::Synchronize(uint32_t use) {
  Timed([&](vesper_error* error) { return desc_.synchronize(law_, use, error); });
}

double Law::PotentialEnergy() {
  double energy = 0;
  Call([&](vesper_error* error) { return desc_.potential_energy(law_, &energy, error); });
  if (std::isfinite(energy)) return energy;
  throw Failure(VESPER_LAW_MISBEHAVED, "%s: its potential energy is %g, expected a number",
                label_.c_str(), energy);
}

}  // namespace vesper
