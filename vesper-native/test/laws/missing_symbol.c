// SPDX-License-Identifier: Apache-2.0
/* Imports a function that no library provides. */
#include "vesper/law.h"

const vesper_law_library* a_function_that_nobody_has(void);

const vesper_law_library* vesper_law_library_entry(void) { return a_function_that_nobody_has(); }
