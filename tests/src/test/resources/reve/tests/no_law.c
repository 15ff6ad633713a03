// SPDX-License-Identifier: Apache-2.0
/* A shared library, but no law library. */
int answer(void) { return 42; }
