// SPDX-License-Identifier: Apache-2.0
// Takes from this process everything that a law does not need, in several layers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace vesper::apart {

/// The layers that a system may lack. `no_new_privs` and the resource limits exist everywhere.
enum Layer : uint32_t {
  kUserNamespace,
  kPidNamespace,
  kNetworkNamespace,
  kIpcNamespace,
  kMountNamespace,
  kLandlock,
  kSeccomp,
  kLayerCount,
};

/// Returns the name of a layer for messages; static.
const char* LayerName(Layer layer);

/// Which layers protect a process: for each one 0, or the error number with which it was refused.
struct Layers {
  int32_t error[kLayerCount] = {};

  bool IsComplete() const;
  /// Returns e.g. "the user namespace (Operation not permitted) and Landlock (…)".
  std::string Missing() const;
};

/// Moves this process, or the child that it starts next, into namespaces of its own.
void EnterNamespaces(Layers& layers);

/// Makes the file system of this process consist of one read-only file with these bytes, if it has
/// a mount namespace. Returns the path of the file, or an empty text.
std::string EnterEmptyRoot(std::span<const std::byte> bytes, const std::string& name,
                           Layers& layers);

/// Gives up identity and capabilities of root.
void DropPrivileges(Layers& layers);

/// Sets the resource limits: `memory` bytes of its own, few descriptors, no child processes, no
/// core files.
void LimitResources(uint64_t memory);

/// Permits access to no file except `path` (none, if it is empty), and to no network.
void EnterLandlock(const std::string& path, Layers& layers);

}  // namespace vesper::apart
