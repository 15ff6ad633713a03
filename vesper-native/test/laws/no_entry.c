// SPDX-License-Identifier: Apache-2.0
/* A sound shared object that is no law library. */
int nothing_to_see_here;
