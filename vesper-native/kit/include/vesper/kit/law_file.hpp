// SPDX-License-Identifier: Apache-2.0
// A law library as a file, and as code called without an engine.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "vesper/law.h"

namespace vesper {

/// A mapped law library. Throws std::runtime_error if it cannot be loaded.
class LawFile {
 public:
  explicit LawFile(const std::string& path);

  /// From libvesper_law_NAME.so.
  static std::string NameOf(const std::string& path);

  const vesper_law_library& table() const { return *table_; }
  /// Laws of one precision, in the order of the table.
  std::vector<const vesper_law_desc*> Laws(vesper_scalar_type real_type) const;
  /// What it brings for FIELD properties.
  std::span<const vesper_field_desc> Fields() const;

  /// Names of the symbols that it defines for others.
  std::vector<std::string> Exports() const;
  /// File names of the libraries that it asks the loader for.
  std::vector<std::string> Needed() const;
  /// "symbol (file that provides it)" for each one that it takes from outside.
  std::vector<std::string> Imports() const;

 private:
  struct Close {
    void operator()(void* handle) const;
  };
  struct Symbol {
    std::string name;
    bool defined;
    bool weak;
  };
  std::vector<Symbol> DynamicSymbols() const;

  std::string path_;
  std::unique_ptr<void, Close> handle_;
  const vesper_law_library* table_;
};

/// One law, made and bound without an engine, on one thread.
class BareLaw {
 public:
  /// `properties`: one per use of the law, their arrays borrowed. `library`: of the law, if it
  /// needs a suite, which is then its alone.
  BareLaw(const vesper_law_desc& desc, const std::vector<vesper_property>& properties,
          const vesper_law_library* library = nullptr);

  double PotentialEnergy() const;

  struct Time {
    double dt;       // [s]
    uint64_t index;  // of the step
  };
  /// One step: stage 0 if the law integrates and begins there, then each stage after
  /// `evaluate(stage)`, which may fill in forces. The arrays count before and after each call,
  /// deferred or not.
  void Step(const Time& time, const std::function<void(uint32_t)>& evaluate) const;

 private:
  void Advance(const vesper_step& step) const;

  struct Close {
    const vesper_law_library* library;
    void operator()(vesper_suite* suite) const { library->close(suite); }
  };
  struct Destroy {
    const vesper_law_desc* desc;
    void operator()(vesper_law* law) const { desc->destroy(law); }
  };

  void Bind() const;
  void TakeArrays() const;

  const vesper_law_desc& desc_;
  mutable std::vector<vesper_property> properties_;
  std::unique_ptr<vesper_suite, Close> suite_;
  std::unique_ptr<vesper_law, Destroy> law_;
};

}  // namespace vesper
