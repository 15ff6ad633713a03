#include "law.hpp"

#include <chrono>

#include "foreign_call.hpp"

namespace vesper {

Law::Law(const vesper_law_desc& desc) : desc_(desc), label_(std::string("law ") + desc.name) {}

Law::~Law() {
  if (law_ != nullptr) CallForeignQuietly([this] { desc_.destroy(law_); });
}

void Law::Create(const vesper_host& host, vesper_suite* suite,
                 const std::vector<double>& parameters) {
  vesper_law* law = nullptr;
  CallForeign(label_, [&](vesper_error* error) {
    return desc_.create(&host, suite, parameters.data(), &law, error);
  });
  if (law == nullptr) {
    throw Failure(VESPER_LAW_MISBEHAVED, "%s: create returned OK but no law", label_.c_str());
  }
  law_ = law;
}

void Law::Bind(const std::vector<vesper_property>& properties) {
  CallForeign(label_, [&](vesper_error* error) {
    return desc_.bind(law_, properties.data(), error);
  });
}

void Law::Advance(const vesper_step& step) {
  ++calls_;
  const auto start = std::chrono::steady_clock::now();
  CallForeign(label_, [&](vesper_error* error) { return desc_.advance(law_, &step, error); });
  const auto spent = std::chrono::steady_clock::now() - start;
  nanoseconds_ += static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(spent).count());
}

}  // namespace vesper
