// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"
#include "setup.hpp"

using namespace vesper::opencl;

VESPER_LAW_LIBRARY("opencl_motion", OpenClSetup, OpenClMotion)
