// SPDX-License-Identifier: Apache-2.0
// Replaces the part of Debian's static library of asmjit that refers to `stderr`. That part is not
// position-independent, so a shared library cannot contain it.
#include <asmjit/core.h>

#include <cstdlib>

ASMJIT_BEGIN_NAMESPACE

const char* DebugUtils::errorAsString(Error) noexcept { return "asmjit error"; }

void DebugUtils::debugOutput(const char*) noexcept {}

void DebugUtils::assertionFailed(const char*, int, const char*) noexcept { std::abort(); }

ASMJIT_END_NAMESPACE
