// SPDX-License-Identifier: Apache-2.0
#include "gravitation.hpp"
#include "setup.hpp"

using namespace vesper::opencl;

VESPER_LAW_LIBRARY("opencl_gravitation", OpenClSetup, OpenClGravitation)
