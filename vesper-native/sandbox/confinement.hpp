// SPDX-License-Identifier: Apache-2.0
// Layers of protection that remove the rights and resources that a law does not need from this
// process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace vesper::apart {

/// The layers that an operating system may lack. The flag `no_new_privs` and the resource limits
/// exist on every system.
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

/// The layers that protect a process. For each layer, `error` contains 0, or the error number with
/// which the system refused it.
struct Layers {
  int32_t error[kLayerCount] = {};

  bool IsComplete() const;
  /// Describes the refused layers, for example "the user namespace (Operation not permitted) and
  /// Landlock (…)".
  std::string Missing() const;
};

/// Moves this process, or the child that it starts next, into namespaces of its own.
void EnterNamespaces(Layers& layers);

/// Replaces the file system of this process by one read-only file with these bytes. Requires a
/// mount namespace; without it, returns an empty text. Otherwise returns the path of the file.
std::string EnterEmptyRoot(std::span<const std::byte> bytes, const std::string& name,
                           Layers& layers);

/// Removes the user identity and the capabilities of root from this process.
void DropPrivileges(Layers& layers);

/// Sets the resource limits: `memory` bytes of its own, few descriptors, no child processes, no
/// core files.
void LimitResources(uint64_t memory);

/// Forbids this process access to all files except `path`, and to the network. If `path` is empty,
/// forbids access to all files.
void EnterLandlock(const std::string& path, Layers& layers);

}  // namespace vesper::apart
