#include "gravitation.hpp"
#include "setup.hpp"

using namespace vesper::opencl;

VESPER_LAW_LIBRARY("opencl_gravitation", OpenClSetup, OpenClGravitation)
