// SPDX-License-Identifier: Apache-2.0
#include "vesper/kit/test_prototype.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "vesper/vesper.hpp"

namespace vesper {
namespace {

constexpr std::array kStandard{"si-f64", "si-f32"};

size_t IndexOf(vesper_scalar_type real_type) { return real_type == VESPER_F32 ? 1 : 0; }

std::array<std::optional<LoadedPrototype>, 2>& Loaded() {
  static std::array<std::optional<LoadedPrototype>, 2> loaded;
  return loaded;
}

}  // namespace

const vesper_prototype& TestPrototype(vesper_scalar_type real_type) {
  const size_t index = IndexOf(real_type);
  const std::optional<LoadedPrototype>& loaded = Loaded()[index];
  return loaded ? loaded->get() : StandardPrototype(kStandard[index]);
}

void UseTestPrototype(const std::string& path) {
  const LoadedPrototype whole(path);  // reports a file that cannot be read, and its problems
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const size_t header = text.starts_with("prototype ") ? 0 : text.find("\nprototype ");
  const size_t end = text.find('\n', header + 1);
  const size_t base = text.find(" si-f", header);  // of "prototype NAME extends si-f64"
  if (base >= end) {
    throw std::runtime_error(path + ": expected a prototype that extends si-f64 or si-f32");
  }
  const std::string name = std::filesystem::path(path).filename();
  for (size_t i = 0; i < kStandard.size(); ++i) {
    text.replace(base + 1, 6, kStandard[i]);
    Loaded()[i].emplace(text, name);
  }
}

}  // namespace vesper
