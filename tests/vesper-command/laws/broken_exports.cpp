// SPDX-License-Identifier: Apache-2.0
// A law that gives away a symbol of its own.
#define LIBRARY_NAME "broken_exports"
#define FAULT kNone
#include "broken.cpp"

extern "C" VESPER_LAW_EXPORT int also_exported() { return 1; }
