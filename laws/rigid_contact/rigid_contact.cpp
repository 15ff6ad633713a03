// SPDX-License-Identifier: Apache-2.0
#include "rigid_contact.hpp"

VESPER_LAW_LIBRARY("rigid_contact", vesper::rigid::RigidContact)
