// SPDX-License-Identifier: Apache-2.0
#include "gravitation.hpp"
#include "motion.hpp"
#include "setup.hpp"

using namespace vesper::opencl;

VESPER_LAW_LIBRARY("opencl_nbody", OpenClSetup, OpenClGravitation, OpenClMotion)
