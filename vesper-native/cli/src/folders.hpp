// SPDX-License-Identifier: Apache-2.0
// Where the command finds what belongs to it.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

/// The folder that this program lies in.
std::string ProgramFolder();
/// A relative path in a file is meant from the folder that the file lies in.
std::string FromFolderOf(const std::string& file, const std::string& path);
/// The bytes of a file of at most 64 MiB. Throws std::runtime_error if it cannot be read.
std::string ReadFile(const std::string& file);
/// From the environment variable VESPER_LAW_PATH (folders separated by ':'); else the folder
/// `laws` beside this program, if there is one.
std::vector<std::string> DefaultLawFolders();

}  // namespace vesper::cli
