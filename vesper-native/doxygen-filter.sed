# SPDX-License-Identifier: Apache-2.0
# How Doxygen reads the headers: the comment at the top is the page of the file, and the two fields
# that nearly every struct has are explained once, in vesper/types.h.
2s|^/\* |/** @file\n * |
s|^( *uint32_t struct_size;)$|\1 /**< Bytes of this struct, set by whoever fills it. */|
s|^( *uint(8\|32)_t reserved1?;)$|\1 /**< 0. */|
