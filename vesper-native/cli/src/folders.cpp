// SPDX-License-Identifier: Apache-2.0
#include "folders.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace vesper::cli {

std::string ProgramFolder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path().string();
}

std::string FromFolderOf(const std::string& file, const std::string& path) {
  const size_t slash = file.rfind('/');
  return slash == std::string::npos || path.starts_with('/') ? path
                                                             : file.substr(0, slash + 1) + path;
}

std::string ReadFile(const std::string& file, const std::string& shown) {
  constexpr uintmax_t kLargestFile = 64 << 20;
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw std::runtime_error(shown + ": " + error.message());
  if (!std::filesystem::is_regular_file(file, error)) {
    throw std::runtime_error(shown + ": not a regular file");
  }
  if (size > kLargestFile) throw std::runtime_error(shown + ": larger than 64 MiB");
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw std::runtime_error(shown + ": cannot be read");
  return text;
}

bool MayReplace(const std::string& file, const std::string& beginning) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return true;
  std::ifstream stream(file, std::ios::binary);
  std::string found(beginning.size(), '\0');
  stream.read(found.data(), static_cast<std::streamsize>(found.size()));
  return stream.gcount() == 0 || found == beginning;
}

std::vector<std::string> DefaultLawFolders() {
  std::vector<std::string> folders;
  if (const char* path = std::getenv("VESPER_LAW_PATH")) {
    std::istringstream parts(path);
    for (std::string part; std::getline(parts, part, ':');) {
      if (!part.empty()) folders.push_back(part);
    }
    return folders;
  }
  const std::string beside = ProgramFolder() + "/laws";
  if (std::filesystem::is_directory(beside)) folders.push_back(beside);
  return folders;
}

}  // namespace vesper::cli
