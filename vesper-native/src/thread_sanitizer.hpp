// SPDX-License-Identifier: Apache-2.0
// What the thread sanitizer has to be told, because it does not see into TBB: Debian's library is
// not built for it. The one file that uses TBB is therefore compiled without the sanitizer, and
// says here what order TBB gives: so everything outside TBB, laws included, is still checked.
#pragma once

#if defined(VESPER_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

namespace vesper {

/// What this thread did so far comes before what another does after `ComesAfter(point)`.
inline void ComesBefore([[maybe_unused]] void* point) {
#if defined(VESPER_THREAD_SANITIZER)
  __tsan_release(point);
#endif
}

inline void ComesAfter([[maybe_unused]] void* point) {
#if defined(VESPER_THREAD_SANITIZER)
  __tsan_acquire(point);
#endif
}

}  // namespace vesper
