// SPDX-License-Identifier: Apache-2.0
// The files that a scene names. The operator may not know the author of a scene. Therefore a scene
// reads only files in its own folder, unless the operator trusts it.
#pragma once

#include <string>

namespace vesper::cli {

class SceneFiles {
 public:
  /// Stores `scene`, the path of the scene's file, and whether the operator trusts the scene.
  SceneFiles(std::string scene, bool trusted) : scene_(std::move(scene)), trusted_(trusted) {}

  bool trusted() const { return trusted_; }

  /// Returns the path of a file that the scene names; a relative path begins in the scene's folder.
  std::string PathOf(const std::string& name) const;

  /// Returns the bytes of a file of at most 64 MiB. Throws std::runtime_error with the reason if
  /// the file cannot be read. Unless the scene is trusted, only regular files in the scene's folder
  /// or below it are read. Everything else is refused without being read: absolute paths, "..",
  /// links to other places, devices, pipes, and files of the system such as those in /proc.
  std::string Read(const std::string& name) const;

 private:
  std::string ReadWithin(const std::string& name) const;

  std::string scene_;
  bool trusted_;
};

}  // namespace vesper::cli
