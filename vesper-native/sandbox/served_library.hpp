// SPDX-License-Identifier: Apache-2.0
// The law library inside a sandbox.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "exchange.hpp"
#include "law_table.hpp"

namespace vesper::apart {

/// A mapped library, whose laws the sandbox creates, binds and calls on command.
class ServedLibrary {
 public:
  /// `read` and `written` are the segments with the columns.
  ServedLibrary(Exchange& exchange, std::byte* read, std::byte* written);

  /// Maps the library, which runs its static constructors. Throws Failure.
  void Open(const std::string& path, const std::string& source);
  /// Executes the command in the exchange, and writes its result or its error to the exchange.
  void Answer() noexcept;
  /// Makes each later command fail with this error.
  void Refuse(const vesper_error& error) { refused_ = error; }

 private:
  struct Served {
    vesper_law* law = nullptr;
    std::vector<vesper_property> properties;
  };

  void Dispatch();
  void Describe();
  void Create();
  void Bind();
  vesper_law* Law();
  template <class Call>
  void CallLaw(Call&& call);
  static void Log(void* context, uint32_t level, const char* message);
  static void ParallelFor(void* context, uint64_t count, uint64_t grain,
                          void (*body)(void* user, uint64_t begin, uint64_t end), void* user);

  Exchange& exchange_;
  std::byte* read_;
  std::byte* written_;
  void* handle_ = nullptr;
  std::string source_;
  std::vector<LawTable> tables_;  // one, as soon as the library has been described
  vesper_host host_{};
  vesper_suite* suite_ = nullptr;
  std::vector<Served> laws_;
  vesper_error refused_{};
};

}  // namespace vesper::apart
