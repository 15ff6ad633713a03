// Where the command finds what belongs to it.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

/// The folder that this program lies in.
std::string ProgramFolder();
/// From the environment variable VESPER_LAW_PATH (folders separated by ':'); else the folder
/// `laws` beside this program, if there is one.
std::vector<std::string> DefaultLawFolders();

}  // namespace vesper::cli
