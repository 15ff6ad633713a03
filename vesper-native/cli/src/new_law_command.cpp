// SPDX-License-Identifier: Apache-2.0
#include "new_law_command.hpp"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <regex>

#include "exit_code.hpp"
#include "law_templates.hpp"

namespace vesper::cli {
namespace {

/// Converts a snake_case name to the name of a class. For example, uniform_drag becomes
/// UniformDrag.
std::string ClassName(const std::string& name) {
  std::string result;
  bool begins_word = true;
  for (const char c : name) {
    if (c == '_') {
      begins_word = true;
    } else {
      result += begins_word ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
      begins_word = false;
    }
  }
  return result;
}

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

bool Write(const std::filesystem::path& path, const char* text, const std::string& name) {
  std::ofstream file(path, std::ios::binary);
  file << Replace(Replace(text, "@NAME@", name), "@CLASS@", ClassName(name));
  file.close();
  return static_cast<bool>(file);
}

/// Returns the folder with the CMake files of Vesper that belongs to this program, in a build, a
/// release or an installation. Returns an empty path if no such folder exists; CMake then searches
/// for the files.
std::filesystem::path ConfigFolder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  for (const char* place : {".", "../../../native", "../lib/cmake/Vesper"}) {
    const auto folder = (program.parent_path() / place).lexically_normal();
    if (!error && std::filesystem::exists(folder / "VesperConfig.cmake", error)) return folder;
  }
  return {};
}

/// Returns a path, quoted as one word of a shell command.
/// Returns a path as a word of a shell, in quotes if it needs them.
std::string Quoted(const std::filesystem::path& path) {
  const std::string text = path.string();
  if (std::regex_match(text, std::regex("[A-Za-z0-9._/-]+"))) return text;
  return "'" + Replace(text, "'", "'\\''") + "'";
}

}  // namespace

int WriteNewLaw(const NewLawOptions& options) {
  if (!std::regex_match(options.name, std::regex("[a-z][a-z0-9]*(_[a-z0-9]+)*")) ||
      options.name.size() > 47) {
    return Fail(kWrongUsage,
                "'" + options.name +
                    "' is no name for a law; expected snake_case such as uniform_drag, "
                    "at most 47 letters");
  }
  const auto folder = std::filesystem::path(options.folder) / options.name;
  std::error_code error;
  if (!std::filesystem::create_directories(folder, error)) {
    return Fail(kFailed, folder.string() + ": " +
                             (error ? error.message() : "is there already; nothing was written"));
  }
  for (const auto& [file, text] : {std::pair{options.name + ".cpp", kLawSource},
                                   std::pair{options.name + "_test.cpp", kLawTest},
                                   std::pair{std::string("CMakeLists.txt"), kLawCMake},
                                   std::pair{std::string("README.md"), kLawReadme}}) {
    if (!Write(folder / file, text, options.name)) {
      return Fail(kFailed, (folder / file).string() + ": cannot be written");
    }
  }
  const auto config = ConfigFolder();
  const std::string where = config.empty() ? "" : " -DVesper_DIR=" + Quoted(config);
  std::cout << folder.string() << ": written; build and test it with\n"
            << "  cmake -S " << Quoted(folder) << " -B " << Quoted(folder / "build") << where
            << " && cmake --build " << Quoted(folder / "build") << "\n"
            << "  ctest --test-dir " << Quoted(folder / "build") << "\n";
  return kDone;
}

}  // namespace vesper::cli
