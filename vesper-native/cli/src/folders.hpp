// SPDX-License-Identifier: Apache-2.0
// Locations of the command's files.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

/// Returns the folder of this program.
std::string ProgramFolder();
/// Resolves a relative path in a file against the folder of that file.
std::string FromFolderOf(const std::string& file, const std::string& path);
/// Returns the bytes of a file of at most 64 MiB. Throws std::runtime_error, with `shown` as the
/// file's name, if it cannot be read.
std::string ReadFile(const std::string& file, const std::string& shown);
inline std::string ReadFile(const std::string& file) { return ReadFile(file, file); }
/// Returns whether a command may write to the file. Returns false if the file exists and does not
/// begin with `beginning`, the first bytes of the command's own output. The file then contains
/// other data, and an option named it by mistake.
bool MayReplace(const std::string& file, const std::string& beginning);
/// The end of the message about a file that a command may not replace.
inline constexpr char kNotReplaced[] =
    ": exists, and this command has not written it; name another file, or remove it";
/// Returns the folders in the environment variable VESPER_LAW_PATH (separated by ':'). If it is not
/// set, returns the folder `laws` beside this program if it exists.
std::vector<std::string> DefaultLawFolders();

}  // namespace vesper::cli
