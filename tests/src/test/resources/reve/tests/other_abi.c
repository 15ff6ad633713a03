// SPDX-License-Identifier: Apache-2.0
/* A law library for a contract version that does not exist: everything after the version is
   junk. */
#include "vesper/law.h"

static const vesper_law_library kLibrary = {
    .struct_size = sizeof(vesper_law_library),
    .abi_version = 7u << 16 | 3u,
    .name = (const char*)1,
    .law_count = 1000,
    .laws = (const vesper_law_desc*)1,
};

const vesper_law_library* vesper_law_library_entry(void) { return &kLibrary; }
