// SPDX-License-Identifier: Apache-2.0
/* A valid shared object that is not a law library. */
int nothing_to_see_here;
